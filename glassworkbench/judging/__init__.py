"""Judging a camera's image by what the station should see: registration, deviations, findings, a verdict."""

from glassworkbench.errors import InputError

try:
    import scipy  # noqa: F401
    import skimage  # noqa: F401
except ImportError as error:
    raise InputError(
        f"comparing images needs {error.name}, which this Python lacks; install scipy and scikit-image "
        "(Debian: python3-skimage)"
    ) from error

from glassworkbench.judging.compare import Comparison, compare
from glassworkbench.judging.golden_image import GoldenImage, golden_of, read_golden
from glassworkbench.judging.overlay import save_overlay

__all__ = ["Comparison", "GoldenImage", "compare", "golden_of", "read_golden", "save_overlay"]
