"""How a camera's image lies on the golden one: shift, rotation, scale and gain, to a few hundredths of a pixel.

Both are smoothed and halved to a pyramid. At its top turns and scales are tried, each with the shift that the phases'
correlation tells; from there Gauss-Newton with weights by Tukey's biweight, so that defects have no say, goes down
level by level.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage
from skimage.registration import phase_cross_correlation

from glassworkbench.errors import InputError

SMALLEST_SIDE = 48
"""Pixels of the shorter side at the top of the pyramid, at least."""

TURNS_DEG = np.arange(-8.0, 8.1, 2.0)
SCALES = (0.94, 1.0, 1.06)
ITERATIONS = 30
STILL = 1e-4
"""Gauss-Newton ends where no corner of the image moves by more than this, in pixels."""

MOST_POINTS = 200_000
"""Pixels that are looked at on each level; those with the steepest gradients, evenly."""

SURROUNDINGS = 4
"""Pixels around those that are judged which count, too."""

BIWEIGHT = 4.685
"""Tukey's constant: 95 % efficient for normal noise."""

BLUR = 0.8
"""Standard deviation, in pixels, of the smoothing before gradients are taken."""

LEAST_CORRELATION = 0.6
TURNED_BETTER = 0.05
"""An image that correlates so much better upside down or mirrored is so."""


@dataclass(frozen=True)
class Registration:
    """A point x of the golden image is at c + scale R (x - c) + shift in the camera's, c being the image's middle.

    Parameters
    ----------
    shift_px : (float, float)
        Right and down.
    rotation_deg : float
        Counter-clockwise as one looks at the image.
    scale : float
    gain : float
        The camera's values over the golden image's.
    correlation : float
        Of the two images, once registered; 1 is perfect.
    """

    shift_px: tuple[float, float] = (0.0, 0.0)
    rotation_deg: float = 0.0
    scale: float = 1.0
    gain: float = 1.0
    correlation: float = 0.0

    def to_camera(self, column: np.ndarray, row: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """Return column and row in the camera's image of points of the golden one of `size` (width, height)."""
        middle = 0.5 * size[0], 0.5 * size[1]
        angle = np.radians(self.rotation_deg)
        cos, sin = self.scale * np.cos(angle), self.scale * np.sin(angle)
        x, y = column - middle[0], row - middle[1]
        return middle[0] + cos * x + sin * y + self.shift_px[0], middle[1] - sin * x + cos * y + self.shift_px[1]

    def resampled(self, grey: np.ndarray) -> np.ndarray:
        """Return a camera's image as it lies on the golden one, over the gain; NaN where it does not reach."""
        return _sampled(grey, self, *_grid(grey.shape), order=3, fill=np.nan) / self.gain


def register(golden: np.ndarray, camera: np.ndarray, valid: np.ndarray) -> Registration:
    """Return how a camera's image (h, w) lies on the golden one (h, w).

    Parameters
    ----------
    golden, camera : array (h, w)
    valid : array (h, w) of bool
        Pixels of the golden image that count.

    Raises
    ------
    InputError
        If the camera's image does not show what the golden one shows, or shows it upside down or mirrored.
    """
    # A silhouette tells most, and from both of its sides.
    judged = ndimage.binary_dilation(valid, iterations=SURROUNDINGS)
    levels = [(np.asarray(golden, dtype=np.float64), np.asarray(camera, dtype=np.float64), judged.astype(np.float64))]
    while min(levels[-1][0].shape) >= 2 * SMALLEST_SIDE:
        levels.append(tuple(_halved(array) for array in levels[-1]))
    found = _coarse(*levels[-1])
    _check_way_up(found, *levels[-1])
    for k, (fixed, moving, weight) in reversed(list(enumerate(levels))):
        found = _refined(fixed, moving, weight > 0.5, found)
        if k > 0:
            found = replace(found, shift_px=(2.0 * found.shift_px[0], 2.0 * found.shift_px[1]))
    found = replace(found, correlation=_correlation(golden, camera, valid, found))
    if not found.correlation >= LEAST_CORRELATION:
        raise InputError(
            f"image: it does not show what the golden image shows (their correlation is {found.correlation:.2f}, "
            f"{LEAST_CORRELATION:g} is needed); check container, station and exposure"
        )
    return found


def _halved(array: np.ndarray) -> np.ndarray:
    height, width = (side // 2 * 2 for side in array.shape)
    return array[:height, :width].reshape(height // 2, 2, width // 2, 2).mean(axis=(1, 3))


def _grid(shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return column and row (h, w) of the pixels' middles."""
    row, column = np.meshgrid(np.arange(shape[0]) + 0.5, np.arange(shape[1]) + 0.5, indexing="ij")
    return column, row


def _sampled(
    image: np.ndarray, found: Registration, column: np.ndarray, row: np.ndarray, order: int, fill: float
) -> np.ndarray:
    """Return a camera's image at points of the golden one."""
    x, y = found.to_camera(column, row, (image.shape[1], image.shape[0]))
    return ndimage.map_coordinates(image, [y - 0.5, x - 0.5], order=order, mode="constant", cval=fill)


def _coarse(golden: np.ndarray, camera: np.ndarray, weight: np.ndarray) -> Registration:
    valid = weight > 0.5
    column, row = _grid(golden.shape)
    flat = golden - golden.mean()
    best = Registration(correlation=-np.inf)
    for turn in TURNS_DEG:
        for scale in SCALES:
            tried = Registration(rotation_deg=float(turn), scale=scale)
            turned = _sampled(camera, tried, column, row, order=1, fill=float(camera.mean()))
            shift, *_ = phase_cross_correlation(turned - turned.mean(), flat, normalization=None)
            # The shift was found in the turned image; a camera's image shifts after the turn.
            angle = np.radians(turn)
            right = scale * (np.cos(angle) * shift[1] + np.sin(angle) * shift[0])
            down = scale * (-np.sin(angle) * shift[1] + np.cos(angle) * shift[0])
            for moved in (tried, replace(tried, shift_px=(float(right), float(down)))):
                correlation = _correlation(golden, camera, valid, moved)
                if correlation > best.correlation:
                    best = replace(moved, correlation=correlation)
    return best


def _check_way_up(found: Registration, golden: np.ndarray, camera: np.ndarray, weight: np.ndarray) -> None:
    ways = {"turned by 180 degrees": camera[::-1, ::-1], "mirrored": camera[:, ::-1], "upside down": camera[::-1]}
    for name, other in ways.items():
        correlation = _coarse(golden, other, weight).correlation
        if correlation > max(found.correlation + TURNED_BETTER, LEAST_CORRELATION):
            raise InputError(
                f"image: it is {name} to the golden image (correlation {correlation:.2f} so, {found.correlation:.2f} "
                "as it is); turn it as the golden image is"
            )


def _correlation(golden: np.ndarray, camera: np.ndarray, valid: np.ndarray, found: Registration) -> float:
    """Return Pearson's correlation over the valid pixels that both have; 0 where they share less than half."""
    column, row = _grid(golden.shape)
    seen = _sampled(camera, found, column, row, order=1, fill=np.nan)
    both = valid & np.isfinite(seen)
    if both.sum() < max(16, valid.sum() // 2):
        return 0.0
    a, b = golden[both] - golden[both].mean(), seen[both] - seen[both].mean()
    norm = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / norm if norm > 0.0 else 0.0


def _refined(golden: np.ndarray, camera: np.ndarray, valid: np.ndarray, start: Registration) -> Registration:
    """Return the registration that Gauss-Newton reaches on one level."""
    fixed, moving = ndimage.gaussian_filter(golden, BLUR), ndimage.gaussian_filter(camera, BLUR)
    by_row, by_column = np.gradient(moving)
    points = _telling(fixed, valid)
    column, row = (grid[points] for grid in _grid(golden.shape))
    here = fixed[points]
    height, width = golden.shape
    found = start
    reach = 0.5 * float(np.hypot(width, height))
    for _ in range(ITERATIONS):
        seen, slope_x, slope_y = (
            _sampled(image, found, column, row, order=order, fill=np.nan)
            for image, order in ((moving, 3), (by_column, 1), (by_row, 1))
        )
        inside = np.isfinite(seen) & np.isfinite(slope_x) & np.isfinite(slope_y)
        if inside.sum() < 16:
            return start
        seen, slope_x, slope_y, aim = seen[inside], slope_x[inside], slope_y[inside], here[inside]
        x, y = found.to_camera(column[inside], row[inside], (width, height))
        x, y = x - 0.5 * width - found.shift_px[0], y - 0.5 * height - found.shift_px[1]
        if found is start:
            gain = float(aim @ seen) / max(float(aim @ aim), 1e-300)
            found = replace(found, gain=gain)
        # By shift, rotation, logarithm of the scale, and gain.
        slopes = np.stack([slope_x, slope_y, slope_x * y - slope_y * x, slope_x * x + slope_y * y, -aim], axis=1)
        off = seen - found.gain * aim
        spread = 1.4826 * float(np.median(np.abs(off - np.median(off)))) + 1e-9 * abs(found.gain)
        weights = np.where(np.abs(off) < BIWEIGHT * spread, (1.0 - (off / (BIWEIGHT * spread)) ** 2) ** 2, 0.0)
        weighted = slopes * weights[:, None]
        step = -np.linalg.lstsq(weighted.T @ slopes, weighted.T @ off, rcond=None)[0]
        found = replace(
            found,
            shift_px=(found.shift_px[0] + float(step[0]), found.shift_px[1] + float(step[1])),
            rotation_deg=found.rotation_deg + float(np.degrees(step[2])),
            scale=found.scale * float(np.exp(np.clip(step[3], -0.1, 0.1))),
            gain=found.gain + float(step[4]),
        )
        if max(abs(step[0]), abs(step[1]), reach * abs(step[2]), reach * abs(step[3])) < STILL:
            break
    return found


def _telling(golden: np.ndarray, valid: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return rows and columns of the valid pixels that tell most of the place: of steep ones every so many."""
    slope = np.hypot(*np.gradient(golden))
    steep = valid & (slope >= np.median(slope[valid]))
    rows, columns = np.nonzero(steep)
    stride = max(1, len(rows) // MOST_POINTS)
    return rows[::stride], columns[::stride]
