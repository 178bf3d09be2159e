"""The price list: error against seconds of the choices for a scene."""

from __future__ import annotations

import csv
import json
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

from glassworkbench import __version__
from glassworkbench.errors import InputError
from glassworkbench.images import Image
from glassworkbench.output import check_drawing, check_writable, written_aside
from glassworkbench.pricing.choices import Choice, exact, simplified, truth
from glassworkbench.pricing.drawing import save_crops, save_plot
from glassworkbench.pricing.survey import STEP, TRUE_STEP, Survey, error
from glassworkbench.scene import Scene
from glassworkbench.scene.validate import positive
from glassworkbench.tracer import Cancel, native, render

TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)

FINEST_COMPARED = 1e-2
"""The tolerance at which meshes and effects are compared, where it is affordable."""

SECONDS = 300.0
"""What the dearest point may take, if nothing else is asked."""

PILOT_SECONDS = 20.0
"""What the prediction takes, roughly; less where a point may take less."""

CROP = 48
"""Pixels along a crop."""

CROP_SECONDS = 4.0
"""What a crop may take where no image is measured from which to cut it."""

TABLE, DATA, PLOTS, CROPS = "prices.csv", "prices.json", ("prices.png", "prices.svg"), "crops.png"


@dataclass(frozen=True)
class Price:
    """What a choice costs and how wrong it is; None where it is not known.

    Parameters
    ----------
    name, kind : str
    tolerance : float
    predicted_seconds, predicted_cpu_seconds, predicted_error : float
        Errors are root mean squares over the pixels, of the channel that is most off, in radiance.
    extrapolated : bool
        Whether the prediction goes beyond the tolerances whose errors the pilot could tell.
    seconds, cpu_seconds, error : float or None
        Measured.
    certificate_p99 : float or None
        What 99 % of the measured image's pixels promise.
    """

    name: str
    kind: str
    tolerance: float
    predicted_seconds: float
    predicted_cpu_seconds: float
    predicted_error: float
    extrapolated: bool
    seconds: float | None = None
    cpu_seconds: float | None = None
    error: float | None = None
    certificate_p99: float | None = None


@dataclass(frozen=True, eq=False)
class PriceList:
    """The prices of a scene.

    Parameters
    ----------
    prices : tuple of Price
    crops : tuple of (str, Image)
        The same part of the image by some of the choices, the finest last.
    size : (int, int)
        Of the whole image, in pixels.
    threads : int
    pilot_seconds : float
        What the prediction took.
    reference : str or None
        What measured errors are differences to.
    """

    prices: tuple[Price, ...]
    crops: tuple[tuple[str, Image], ...]
    size: tuple[int, int]
    threads: int
    pilot_seconds: float
    reference: str | None = None

    def to_json(self) -> dict:
        """Return all but the crops as plain values."""
        return {
            "size": list(self.size),
            "threads": self.threads,
            "pilot_seconds": round(self.pilot_seconds, 3),
            "reference": self.reference,
            "prices": [asdict(price) for price in self.prices],
            "version": __version__,
        }

    def save(self, folder: str | os.PathLike) -> None:
        """Write prices.csv, prices.json, prices.png, prices.svg and crops.png into a folder, which may be new.

        Raises
        ------
        InputError
            If nothing can be written there, or matplotlib is missing.
        """
        folder = writable_folder(folder)
        folder.mkdir(exist_ok=True)
        with written_aside(folder / TABLE) as aside, open(aside, "w", newline="", encoding="utf-8") as file:
            table = csv.DictWriter(file, [field.name for field in fields(Price)])
            table.writeheader()
            table.writerows(asdict(price) for price in self.prices)
        with written_aside(folder / DATA) as aside:
            aside.write_text(json.dumps(self.to_json(), indent=2) + "\n", encoding="utf-8")
        for name in PLOTS:
            save_plot(self.prices, folder / name)
        save_crops(self.crops, folder / CROPS)


def writable_folder(folder: str | os.PathLike) -> Path:
    """Return the path of a folder that a price list can be written into, or made for it.

    Raises
    ------
    InputError
        If it is a file, or cannot be written into or made, or matplotlib is missing.
    """
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: it is a file; name a folder for the price list")
    check_writable(folder / TABLE if folder.is_dir() else folder)
    check_drawing(folder.parent / CROPS, "a price list")
    return folder


def accuracy(
    scene: Scene,
    *,
    seconds: float = SECONDS,
    measure: bool = False,
    tolerances: Sequence[float] = TOLERANCES,
    threads: int | None = None,
    cancel: Cancel | None = None,
    progress: Callable[[float], None] | None = None,
) -> PriceList:
    """Tell what accuracy costs for a scene: unbent light, meshes, each effect switched, exact at several tolerances.

    Parameters
    ----------
    scene : Scene
    seconds : float
        What a point may take: finer tolerances are left out, and meshes and effects that would take longer are not
        measured. The prediction itself takes some twenty seconds, or this if it is less.
    measure : bool
        Render the points, and the finest image that the seconds afford, with every effect on, as their reference.
    tolerances : sequence of float
        Of the exact renderings.
    threads : int, optional
        All processors where not given.
    cancel : Cancel, optional
        Set from any thread.
    progress : callable, optional
        Called with the done share of the work, 0 to 1.

    Returns
    -------
    PriceList

    Raises
    ------
    InputError
        If the seconds are too few for the coarsest tolerance, or an argument cannot be used.
    Cancelled
        If `cancel` was set.
    """
    if not isinstance(scene, Scene):
        raise InputError(f"scene: {scene!r} is no scene; give what station or read_scene returns")
    seconds = positive(seconds, "seconds")
    tolerances = sorted({positive(tolerance, "tolerance") for tolerance in tolerances}, reverse=True)
    if not tolerances:
        raise InputError("tolerances: there are none; give one at least, like 0.01")
    if threads is not None and threads < 1:
        raise InputError(f"threads: must be at least 1, got {threads}")
    threads, cancel = threads or native.default_threads(), cancel or Cancel()
    tell = progress or (lambda share: None)

    began = time.perf_counter()
    survey = Survey(scene, tolerances, min(PILOT_SECONDS, seconds), threads, cancel)
    affordable = [tolerance for tolerance in tolerances if survey.exact(tolerance)[0][0] <= seconds]
    if not affordable:
        raise InputError(
            f"seconds: {seconds:g} is too few, the image at a tolerance of {tolerances[0]:g} takes about "
            f"{survey.exact(tolerances[0])[0][0]:.2g}; allow more, or ask for a smaller image"
        )
    compared = min([tolerance for tolerance in affordable if tolerance >= FINEST_COMPARED] or affordable[:1])
    choices = simplified(scene, compared)
    listed = [
        (choice, _price(choice, cost, wrong, False))
        for choice, (cost, wrong) in zip(choices, survey.tried(choices), strict=True)
    ]
    for tolerance in affordable:
        cost, wrong, is_traced = survey.exact(tolerance)
        listed.append((exact(scene, tolerance), _price(exact(scene, tolerance), cost, wrong, not is_traced)))
    pilot_seconds = time.perf_counter() - began
    window = _window(scene.size, survey.most_differing(choices[0]))

    if not measure:
        share = window[2] * window[3] / (scene.size[0] * scene.size[1])
        crops = []
        for done, (choice, price) in enumerate(listed):
            tell((done + 1) / (len(listed) + 1))
            if share * price.predicted_seconds <= CROP_SECONDS:
                crops.append((choice.name, _rendered(choice, threads, cancel, window)))
        tell(1.0)
        prices = tuple(price for _, price in listed)
        return PriceList(prices, tuple(crops), scene.size, threads, pilot_seconds)

    finest = _reference_tolerance(survey, affordable[-1], seconds)
    reference = truth(scene, finest)
    true = _rendered(reference, threads, cancel)
    prices, crops = [], []
    for done, (choice, price) in enumerate(listed):
        tell((done + 1) / (len(listed) + 1))
        if price.predicted_seconds > seconds:
            prices.append(price)
            continue
        clocks = time.perf_counter(), time.process_time()
        image = _rendered(choice, threads, cancel)
        spent, cpu = time.perf_counter() - clocks[0], time.process_time() - clocks[1]
        is_known = choice.kind != "exact" or choice.tolerance > TRUE_STEP * finest
        wrong = error(image.pixels, true.pixels) if is_known else None
        promised = image.report["certificate"]["total_p99"]
        prices.append(replace(price, seconds=spent, cpu_seconds=cpu, error=wrong, certificate_p99=promised))
        crops.append((choice.name, _cut(image, window)))
    crops.append((reference.name, _cut(true, window)))
    tell(1.0)
    return PriceList(tuple(prices), tuple(crops), scene.size, threads, pilot_seconds, reference.name)


def _price(choice: Choice, cost: Sequence[float], wrong: float, is_extrapolated: bool) -> Price:
    return Price(choice.name, choice.kind, choice.tolerance, float(cost[0]), float(cost[1]), wrong, is_extrapolated)


def _rendered(choice: Choice, threads: int, cancel: Cancel, crop: tuple[int, int, int, int] | None = None) -> Image:
    return render(
        choice.scene,
        tolerance=choice.tolerance,
        effects=choice.effects,
        threads=threads,
        cancel=cancel,
        crop=crop,
    )


def _reference_tolerance(survey: Survey, tolerance: float, seconds: float) -> float:
    """Return the finest tolerance, in steps from one that is affordable, whose image is affordable."""
    for _ in range(4):
        if survey.exact(tolerance * STEP)[0][0] > seconds:
            break
        tolerance *= STEP
    return tolerance


def _window(size: tuple[int, int], middle: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return left, top, width, height of a crop about a pixel, wholly in the image."""
    width, height = min(CROP, size[0]), min(CROP, size[1])
    left = min(max(middle[0] - width // 2, 0), size[0] - width)
    top = min(max(middle[1] - height // 2, 0), size[1] - height)
    return left, top, width, height


def _cut(image: Image, window: tuple[int, int, int, int]) -> Image:
    left, top, width, height = window
    rows, columns = slice(top, top + height), slice(left, left + width)
    return Image(
        image.pixels[rows, columns],
        image.certificate[rows, columns],
        image.depth_mm[rows, columns],
        image.metadata,
        image.report,
        corner=(left, top),
        whole=image.whole,
    )
