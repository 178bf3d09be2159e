"""Images: radiance with an error bound per pixel, tone curve, files through OpenImageIO."""

from glassworkbench.images.image import IMAGE_ENDINGS, Image, read_image
from glassworkbench.images.tone import from_display, luminance, to_display
from glassworkbench.output import check_writable

__all__ = ["IMAGE_ENDINGS", "Image", "check_writable", "from_display", "luminance", "read_image", "to_display"]
