"""Images: radiance with an error bound per pixel, tone curve, files through OpenImageIO."""

from glassworkbench.images.image import IMAGE_ENDINGS, Image, read_image
from glassworkbench.images.tone import from_display, to_display
from glassworkbench.output import check_writable

__all__ = ["IMAGE_ENDINGS", "Image", "check_writable", "from_display", "read_image", "to_display"]
