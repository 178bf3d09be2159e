"""Images of a bottle-like shape as a function of the place: known anywhere, so moving them needs no interpolation."""

import numpy as np

from glassworkbench.judging import GoldenImage
from glassworkbench.scene.image_scale import ImageScale

WIDTH, HEIGHT = 240, 320
SUBSAMPLES = 4
SCALE = ImageScale("side", px_per_mm=4.0, rows_per_mm=4.0, axis_column=120.0, base_row=300.0, azimuth_deg=-90.0)


def brightness(x, y):
    """Of a bottle in bright field, by place in pixels of the golden image: dark edges, a label panel, a heel."""
    half = 30 + 45 / (1 + np.exp(-(y - 110) / 6))
    edge = np.clip((half - np.abs(x - 122)) / 6, 0, 1)
    glass = 0.35 + 0.5 * edge * (0.85 + 0.1 * np.sin(x / 9) * np.cos(y / 13))
    glass = np.where((np.abs(x - 105) < 15) & (np.abs(y - 200) < 30), 0.85 * glass, glass)
    glass = np.where(y > 285, 0.6 * glass, glass)
    inside = (np.abs(x - 122) < half) & (y > 20) & (y < 300)
    return np.where(inside, glass, 0.9)


def valid():
    x, y = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
    half = 30 + 45 / (1 + np.exp(-(y - 110) / 6))
    return (np.abs(x - 122) < half) & (y > 20) & (y < 300)


def image(shift=(0.0, 0.0), rotation_deg=0.0, scale=1.0, gain=1.0, blobs=()):
    """The camera's image (h, w) of the golden one moved so; blobs are (x, y, radius, factor) on the golden image."""
    steps = (np.arange(SUBSAMPLES) + 0.5) / SUBSAMPLES
    x, y = np.meshgrid(
        (np.arange(WIDTH)[:, None] + steps).ravel() - 0.5 * WIDTH - shift[0],
        (np.arange(HEIGHT)[:, None] + steps).ravel() - 0.5 * HEIGHT - shift[1],
    )
    # Complex numbers, with up as the imaginary axis, turn by their product.
    back = (x - 1j * y) * np.exp(-1j * np.radians(rotation_deg)) / scale
    x, y = back.real + 0.5 * WIDTH, -back.imag + 0.5 * HEIGHT
    value = brightness(x, y)
    for column, row, radius, factor in blobs:
        value = np.where(np.hypot(x - column, y - row) < radius, factor * value, value)
    return gain * value.reshape(HEIGHT, SUBSAMPLES, WIDTH, SUBSAMPLES).mean(axis=(1, 3))


def golden(sigma=0.01):
    mean, judged = image(), valid()
    zone = np.where(judged, 1, 0)
    zone[110:] = np.where(judged[110:], 2, 0)
    spread = np.full(mean.shape, sigma)
    return GoldenImage(
        nominal=mean,
        mean=mean,
        sigma=spread,
        lower=mean - 1.96 * spread,
        upper=mean + 1.96 * spread,
        valid=judged,
        zone=zone,
        zones=("finish", "body"),
        scale=SCALE,
        metadata={"glass": "flint"},
    )
