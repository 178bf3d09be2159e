"""The command line: honest exit codes, errors in one sentence, and nothing on stdout but the answer."""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import json
import math
import os
import re
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from glassworkbench import __version__
from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.flaws import kinds, parse_defects, populations, with_defects
from glassworkbench.flaws.kinds import described as described_defect
from glassworkbench.glass import Filling, Glass, catalogue, facts, fillings, find_filling, find_glass, refused
from glassworkbench.glass.facts import in_words
from glassworkbench.glass.pictures import CURVES, SWATCHES, save_curves, save_swatches
from glassworkbench.glass.swatch import shown_colour
from glassworkbench.images import IMAGE_ENDINGS, Image
from glassworkbench.output import check_drawing, check_writable, written_aside
from glassworkbench.pricing import SECONDS, PriceList, accuracy, writable_folder
from glassworkbench.scene import ContainerGeometry, Revolved, Scene, Surface
from glassworkbench.scene.file import read_scene
from glassworkbench.scene.scene import MAXIMUM_SIDE
from glassworkbench.settings import unknown_name
from glassworkbench.staging import check_station, described, parse_fill, sample_container, station, stations
from glassworkbench.staging.layout import LAYOUT, save_layout
from glassworkbench.tracer import Cancel, render
from glassworkbench.tracer.plan import EFFECTS

DONE, FAILED, BAD_INPUT = 0, 1, 2

MAXIMUM_PIXELS = 100_000_000
"""More would take tens of gigabytes."""

CONTAINER_ENDINGS = (".step", ".stp", ".brep", ".fcstd", ".stl")


def main(arguments: Sequence[str]) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : sequence of str
        What the user typed after the program's name.

    Returns
    -------
    int
        The exit code: 0 done, 1 failed or cancelled, 2 bad input.
    """
    verbose = "--verbose" in arguments
    try:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        options = _parse(arguments)
        with _warnings_told(options.quiet):
            options.run(options)
        sys.stdout.flush()
    except SystemExit as stop:
        # argparse leaves this way after --help and --version.
        return int(stop.code or DONE)
    except BrokenPipeError:
        # Who read the answer, as head does, has gone: Python would complain again when it flushes at the end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except InputError as error:
        return _told(error, BAD_INPUT, verbose)
    except KeyboardInterrupt:
        return _told("cancelled", FAILED, verbose)
    except GlassWorkbenchError as error:
        return _told(error, FAILED, verbose)
    except Exception as error:
        return _told(f"unexpected {type(error).__name__}: {error}; --verbose shows where", FAILED, verbose)
    return DONE


def _told(error: object, code: int, verbose: bool) -> int:
    if verbose:
        traceback.print_exc()
    print("glassworkbench:", _in_options(" ".join(str(error).split())), file=sys.stderr)
    return code


_OPTIONS = {
    "outer_shell=True": "--outer-shell",
    "block=True": "--block",
    "close_open_shell=True": "--close",
    "accept_best=True": "--best",
    "thickness=": "--wall ",
    "finish_height_mm=": "--finish-height ",
    "finish_height_mm": "--finish-height",
    "scale_to_mm=": "--scale ",
    "scale_to_mm": "--scale",
    "tolerance_mm": "--tolerance",
    "resume=True": "--resume",
}
"""What the rooms call by its name in Python, and how it is called here."""


def _in_options(sentence: str) -> str:
    """Return a sentence of the other rooms in the words of the command line."""
    for name, option in _OPTIONS.items():
        sentence = sentence.replace(name, option)
    return sentence


@contextmanager
def _warnings_told(quiet: bool) -> Iterator[None]:
    """Show a warning as one sentence, without the line of Python that gave it."""

    def tell(message: Warning | str, *_: object) -> None:
        if not quiet:
            print("glassworkbench:", " ".join(str(message).split()), file=sys.stderr)

    with warnings.catch_warnings():
        warnings.showwarning = tell
        yield


class _Parser(argparse.ArgumentParser):
    """A parser that complains in one sentence."""

    def error(self, message: str) -> None:
        raise InputError(f"{message}; {self.prog} --help tells more")


def _parse(arguments: Sequence[str]) -> argparse.Namespace:
    common = _Parser(add_help=False)
    common.add_argument("--quiet", action="store_true", default=argparse.SUPPRESS, help="say nothing but the answer")
    common.add_argument("--verbose", action="store_true", default=argparse.SUPPRESS, help="show where an error arose")
    parser = _Parser(
        prog="glassworkbench",
        parents=[common],
        allow_abbrev=False,
        description="From the mold of a glass container to the container, and what light makes of it.",
        epilog="glassworkbench VERB --help tells more about a verb.",
    )
    parser.add_argument("--version", action="version", version=f"GlassWorkbench {__version__}")
    verbs = parser.add_subparsers(metavar="VERB", dest="verb", required=True)
    for name, (prepare, run, summary, example) in _VERBS.items():
        verb = verbs.add_parser(
            name,
            parents=[common],
            allow_abbrev=False,
            help=summary,
            description=f"{summary[0].upper()}{summary[1:]}.",
            epilog=f"Example: glassworkbench {name} {example}",
        )
        prepare(verb)
        verb.set_defaults(run=run, verb_parser=verb)

    asked = next((word for word in arguments if not word.startswith("-")), None)
    if asked is not None and asked not in _VERBS:
        raise unknown_name("verb", asked, _VERBS)
    options, unknown = parser.parse_known_args(arguments, argparse.Namespace(quiet=False, verbose=False))
    if unknown and unknown[0].startswith("-"):
        known = set(re.findall(r"(?<!\w)--[a-z-]+", options.verb_parser.format_help()))
        raise unknown_name(f"{asked}: option", unknown[0].partition("=")[0], known)
    if unknown:
        raise InputError(f"{asked}: {unknown[0]!r} is one argument too many; quote a name that holds spaces")
    return options


# inspect


def _prepare_inspect(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("mold", metavar="MOLD", help="STEP, IGES, BREP or FCStd file, or a mesh (STL, OBJ, PLY)")
    _add_mold_options(parser)
    parser.add_argument("--json", action="store_true", help="answer in JSON")


def _inspect(options: argparse.Namespace) -> None:
    _check_input(options.mold)
    _check_positive(options, "scale", "finish_height")
    from glassworkbench.mold import inspect
    from glassworkbench.mold.inspection_words import in_words

    found = inspect(options.mold, **_mold_options(options))
    found["faults"] = [_in_options(fault) for fault in found["faults"]]
    print(_json(found) if options.json else _in_options("\n".join(in_words(found))))


# hollow


def _prepare_hollow(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "mold", metavar="MOLD", help="the container's outer shape: STEP, IGES, BREP, FCStd, or a mesh (STL, OBJ, PLY)"
    )
    _add_wall_options(parser, required=True)
    parser.add_argument(
        "--defects", metavar="FILE", help="lean, thin spots and the like from a .toml file; the verb defects lists them"
    )
    parser.add_argument("--tolerance", type=float, metavar="MM", help="how far the wall may be from what was asked")
    parser.add_argument("--seconds", type=float, default=120.0, metavar="S", help="time for all methods (120)")
    parser.add_argument("--best", action="store_true", help="take the best result where none is within the tolerance")
    parser.add_argument(
        "-o", "--output", required=True, metavar="OUT", help="the ending decides: .step .brep .FCStd .stl"
    )
    parser.add_argument("--map", metavar="PICTURE", help="draw the thickness of the wall: .png .svg .pdf")
    parser.add_argument(
        "--fill-point", metavar="FILL", help="report the capacity up to a height, as 250mm, or the level of 750ml"
    )
    _add_report_options(parser)


def _hollow(options: argparse.Namespace) -> None:
    started = time.perf_counter()
    output = check_writable(options.output, CONTAINER_ENDINGS)
    _check_of_wall(options.defects)
    outputs = [output]
    if options.map is not None:
        outputs.append(check_drawing(options.map, "a map of the wall"))
    _check_files(options, outputs)
    _check_positive(options, "scale", "finish_height", "tolerance", "seconds")
    _check_mesh_output(options.mold, output)
    fill = None if options.fill_point is None else _quantity(options.fill_point)
    spent: dict[str, float] = {}
    with _timed(spent, "reading"):
        mold = _mold(options)
    with _timed(spent, "hollowing"):
        container = _hollowed(options, mold, started)
    report = container.report.to_json() | {"input": _input(options.mold), "version": __version__}
    if fill is not None:
        number, unit = fill
        level = container.room.level_mm(number) if unit == "ml" else number
        report["fill_point"] = container.filled(level).to_json()
    with _timed(spent, "writing"):
        container.save(output)
    if options.map is not None:
        with _timed(spent, "map"):
            container.save_map(options.map)
    report |= {"seconds": round(time.perf_counter() - started, 3), "seconds_of": spent}
    _tell_notes(options, container.report.notes)
    _answer(options, report, f"{', '.join(map(str, outputs))}: {_told_of_wall(container, output, report)}")


@contextmanager
def _timed(spent: dict[str, float], name: str) -> Iterator[None]:
    """Put down under a name how many seconds the block takes."""
    begin = time.perf_counter()
    yield
    spent[name] = round(time.perf_counter() - begin, 3)


def _tell_notes(options: argparse.Namespace, notes: Sequence[str]) -> None:
    """Tell what the user should know besides the answer, which --json holds anyway."""
    if options.quiet or options.json:
        return
    for note in notes:
        print("glassworkbench: note:", _in_options(note), file=sys.stderr)


def _check_of_wall(text: str | None) -> None:
    """Tell that what is in the glass alone is no part of a solid."""
    if text is None:
        return
    defects = parse_defects(text)
    others = [defect for defect in getattr(defects, "defects", ()) if defect not in defects.of_wall]
    if others or not defects.of_wall:
        told = f"{others[0]}: it" if others else f"--defects {text}: all of it"
        raise InputError(f"{told} lies in the glass, not in the wall's shape; show it by render --defects")


def _check_mesh_output(mold: str, output: Path) -> None:
    """Tell before the work that the container of a mesh cannot be written as a solid."""
    from glassworkbench.mold.read import MESH_ENDINGS

    if Path(mold).suffix.lower() in MESH_ENDINGS and output.suffix.lower() != ".stl":
        raise InputError(f"{output}: the container of a mesh is a mesh, too; let the name end in .stl")


def _hollowed(options: argparse.Namespace, mold: object, started: float) -> object:
    """Return the container; where no method makes it, leave a report of what was tried, and how long, all the same."""
    from glassworkbench.wall import HollowingError

    limits = {"tolerance_mm": options.tolerance, "seconds": options.seconds, "accept_best": options.best}
    try:
        return _container(options, mold, **limits)
    except HollowingError as error:
        if options.report is not None:
            tried = [attempt.to_json() for attempt in error.tried]
            report = {"method": None, "tried": tried, "input": _input(options.mold), "version": __version__}
            _write_report(options.report, report | {"seconds": round(time.perf_counter() - started, 3)})
        raise


def _quantity(text: str) -> tuple[float, str]:
    """Return the number and the unit, mm or ml, of a fill point."""
    match = re.fullmatch(r"\s*([0-9]+(?:\.[0-9]*)?|\.[0-9]+)\s*(mm|ml)\s*", text)
    if match is None or float(match[1]) == 0.0:
        raise InputError(f"--fill-point: must be a height as 250mm or a quantity as 750ml, got {text!r}")
    return float(match[1]), match[2]


def _told_of_wall(container: object, output: Path, report: Mapping) -> str:
    from glassworkbench.wall.asking.shortened import shortened
    from glassworkbench.wall.container import STL_DEVIATION_MM

    wall, fill = report["wall"], report.get("fill_point")
    told = [
        f"wall {shortened(container.thickness)} by {report['method']}",
        f"99 % within {wall['deviation_p99_mm']:.2g} mm",
        f"{report['weight_g']:.0f} g",
        f"{report['brimful_ml']:.0f} ml brimful",
    ]
    if fill:
        told.append(f"{fill['capacity_ml']:.0f} ml up to {fill['level_mm']:.1f} mm")
    if output.suffix.lower() == ".stl" and container.solid is not None:
        told.append(f"triangles within {STL_DEVIATION_MM:g} mm")
    parts = ", ".join(f"{name} {seconds:.1f}" for name, seconds in report["seconds_of"].items())
    return f"{', '.join(told)}, {report['seconds']:.1f} s ({parts})"


def _add_wall_options(parser: argparse.ArgumentParser, required: bool) -> None:
    parser.add_argument(
        "--wall",
        required=required,
        metavar="SPEC",
        help="thickness in mm, as 3, or 'finish=2.5 body=2 base=5', or 'Face12=4 else=2', or @wall.csv with "
        "height_mm,thickness_mm or height_mm,angle_deg,thickness_mm; 'bore=18.5' with any gives the finish its bore",
    )
    parser.add_argument("--method", metavar="M", help="how to hollow (auto)")
    _add_mold_options(parser)


def _add_mold_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scale", type=float, metavar="F", help="multiply lengths, if the file's unit is wrong")
    parser.add_argument(
        "--finish-height", type=float, metavar="MM", help="the mouth's height above the base, where none is found"
    )
    parser.add_argument("--outer-shell", action="store_true", help="take the outside of a hollow container as the mold")
    parser.add_argument("--block", action="store_true", help="take the void in the solids of a mold block as the mold")
    parser.add_argument("--close", action="store_true", help="close the flat holes of an open surface")


def _mold_options(options: argparse.Namespace) -> dict[str, object]:
    return {
        "scale_to_mm": options.scale,
        "finish_height_mm": options.finish_height,
        "outer_shell": options.outer_shell,
        "block": options.block,
        "close_open_shell": options.close,
    }


def _mold(options: argparse.Namespace) -> object:
    """Return the mold; FreeCAD is imported here and not before, as other verbs run without it."""
    from glassworkbench.mold import read_mold

    return read_mold(options.mold, **_mold_options(options))


def _container(options: argparse.Namespace, mold: object, **limits: float | None) -> object:
    from glassworkbench.wall import flawed_mold, flawed_thickness, hollow

    flaws = parse_defects(options.defects).of_wall if options.defects else ()
    thickness = flawed_thickness(options.wall, mold, flaws)
    return hollow(flawed_mold(mold, flaws), thickness, method=options.method or "auto", **limits)


def _container_as_it_is(options: argparse.Namespace) -> ContainerGeometry:
    for name in ("method", "finish_height", "outer_shell", "block", "close"):
        if getattr(options, name):
            raise InputError(f"--{name.replace('_', '-')}: is for hollowing; give --wall, too, or leave the option out")
    from glassworkbench.wall import read_container

    return read_container(options.mold, scale_to_mm=options.scale)


# render


def _prepare_render(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("mold", metavar="INPUT", help="mold or container (STEP, IGES, BREP, FCStd), or scene (.toml)")
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        action="append",
        metavar="IMAGE",
        help=f"{' '.join(IMAGE_ENDINGS)}; may be given again, to write the image in several formats",
    )
    _add_view_options(parser)
    price = parser.add_mutually_exclusive_group()
    price.add_argument("--tolerance", type=float, metavar="T", help="accepted error of a pixel; white is 1 (0.02)")
    price.add_argument("--seconds", type=float, metavar="S", help="refine until this time is over")
    parser.add_argument("--crop", type=_box, metavar="X,Y,W,H", help="deliver only these pixels of the image")
    parser.add_argument(
        "--region", type=_box, metavar="X,Y,W,H", help="pixels where the tolerance counts; the rest is coarse"
    )
    parser.add_argument("--effects", choices=("auto", "all", "none"), default="auto", help="what to trace (auto)")
    parser.add_argument(
        "--effect", type=_effect, action="append", default=[], metavar="NAME=on|off", help=f"of {', '.join(EFFECTS)}"
    )
    parser.add_argument("--exposure", type=float, default=0.0, metavar="STOPS", help="of .png and .jpg (0)")
    parser.add_argument(
        "--resume", metavar="FILE", help="go on from what an earlier, unfinished run left as IMAGE.checkpoint"
    )
    _add_report_options(parser)


def _add_view_options(parser: argparse.ArgumentParser) -> None:
    _add_wall_options(parser, required=False)
    parser.add_argument("--station", metavar="S", help="where it is seen (studio); the verb stations lists them")
    parser.add_argument("--glass", metavar="G", help="what it is made of (flint); the verb glasses lists them")
    parser.add_argument("--fill", metavar="LIQUID[:LEVEL_MM]", help="what it holds, and up to what height")
    parser.add_argument(
        "--defects",
        metavar="FILE|POPULATION:SEED",
        help="what is wrong with it: a list in a .toml file, or drawn, as seedy:1; the verb defects lists them",
    )
    parser.add_argument("--size", type=_size, metavar="WxH", help="of the image, in pixels (480x640, or the sensor's)")
    parser.add_argument("--threads", type=int, metavar="N", help="all processors where not given")


def _size(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d+)[xX](\d+)", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"{text!r} is no size; write width and height, as 480x640")
    width, height = int(found[1]), int(found[2])
    if not (0 < width <= MAXIMUM_SIDE and 0 < height <= MAXIMUM_SIDE and width * height <= MAXIMUM_PIXELS):
        raise argparse.ArgumentTypeError(
            f"{text} pixels is impossible; each side is 1 to {MAXIMUM_SIDE}, both together at most {MAXIMUM_PIXELS}"
        )
    return width, height


def _box(text: str) -> tuple[int, ...]:
    if re.fullmatch(r"\d+,\d+,\d+,\d+", text) is None:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no part of an image; write left, top, width, height in pixels, as 120,80,64,64"
        )
    return tuple(int(number) for number in text.split(","))


def _effect(text: str) -> tuple[str, bool]:
    name, _, state = text.partition("=")
    if state not in ("on", "off"):
        raise argparse.ArgumentTypeError(f"{text!r}: write NAME=on or NAME=off")
    if name not in EFFECTS:
        raise unknown_name("effect", name, EFFECTS)
    return name, state == "on"


def _render(options: argparse.Namespace) -> None:
    started = time.perf_counter()
    outputs = [check_writable(path, IMAGE_ENDINGS) for path in options.output]
    _check_files(options, outputs)
    _check_positive(options, "scale", "finish_height", "tolerance", "seconds", "threads")
    if not abs(options.exposure) <= 100.0:
        raise InputError(f"--exposure: must lie between -100 and 100 stops, got {options.exposure:g}")
    everything = {"auto": {}, "all": dict.fromkeys(EFFECTS, True), "none": dict.fromkeys(EFFECTS, False)}
    scene = _scene(options)
    set_up_seconds = time.perf_counter() - started
    checkpoint = options.resume or f"{outputs[0]}.checkpoint"
    image = _traced(scene, options, everything[options.effects] | dict(options.effect), checkpoint)
    for path in outputs:
        image.save(path, options.exposure)
    report = dict(image.report) | {"set_up_seconds": round(set_up_seconds, 3), "input": _input(options.mold)}
    _answer(options, report, f"{', '.join(map(str, outputs))}: {_told_of_image(report, options.seconds is None)}")


def _told_of_image(report: Mapping, asked: bool) -> str:
    (width, height), error = report["size"], report["certificate"]["total_p99"]
    missed = f" (asked {report['tolerance']:g})" if asked and error > report["tolerance"] else ""
    return f"{width}x{height}, {report['seconds']:.1f} s, 99 % of pixels within {error:.3g}{missed}"


def _scene(options: argparse.Namespace) -> Scene:
    if Path(options.mold).suffix.lower() == ".toml":
        for name in (
            "wall",
            "method",
            "scale",
            "finish_height",
            "outer_shell",
            "block",
            "close",
            "station",
            "glass",
            "fill",
            "defects",
        ):
            if getattr(options, name):
                raise InputError(
                    f"--{name.replace('_', '-')}: the scene file {options.mold} says it; leave the option out"
                )
        scene = read_scene(options.mold, _read_step)
        return scene if options.size is None else dataclasses.replace(scene, size=options.size)
    glass = find_glass(options.glass or "flint")
    fill = parse_fill(options.fill) if options.fill else None
    defects = parse_defects(options.defects) if options.defects else None
    view = options.station or "studio"
    check_station(view)
    geometry = _container_as_it_is(options) if options.wall is None else _container(options, _mold(options)).geometry()
    scene = station(view, geometry, glass, fill, options.size)
    if defects is not None:
        if options.wall is None and defects.of_wall:
            raise InputError(f"{defects.of_wall[0]}: it is made with the wall; give --wall, too, or leave it out")
        scene = with_defects(scene, geometry, defects.on(geometry))
    told = {"mold": Path(options.mold).name, "wall": options.wall or "as it is"}
    return dataclasses.replace(scene, metadata=told | dict(scene.metadata))


def _read_step(path: Path) -> Surface:
    """Return the surface of a scene file's STEP body where the file has it; exact if it is one of revolution."""
    from glassworkbench.mold import outer_meridian, read_mold
    from glassworkbench.wall.seen import seen_surface

    mold = read_mold(path)
    if mold.anatomy.is_revolved:
        return Revolved(outer_meridian(mold), mold.placement[:3, 3], mold.placement[:3, 2])
    surface, notes = seen_surface(mold.solid, path.name)
    for note in notes:
        print("glassworkbench:", note, file=sys.stderr)
    return surface


def _traced(scene: Scene, options: argparse.Namespace, effects: Mapping[str, bool], checkpoint: str) -> Image:
    return _cancellable(
        "rendering",
        options,
        render,
        scene,
        tolerance=options.tolerance,
        seconds=options.seconds,
        crop=options.crop,
        region=options.region,
        effects=effects,
        checkpoint=checkpoint,
        resume=options.resume is not None,
    )


def _cancellable(label: str, options: argparse.Namespace, work: Callable, scene: Scene, **arguments: object) -> object:
    """Work on another thread, so that this one hears Ctrl-C while the native core is busy."""
    cancel = Cancel()
    with _bar(label, options.quiet) as progress, ThreadPoolExecutor(1) as worker:
        done = worker.submit(work, scene, threads=options.threads, cancel=cancel, progress=progress, **arguments)
        try:
            return done.result()
        except KeyboardInterrupt:
            cancel.set()
            # Its own exception tells whether there is something to go on from.
            done.result()
            raise


@contextmanager
def _bar(label: str, quiet: bool) -> Iterator[Callable[[float], None] | None]:
    """Give a function that shows the share done (0 to 1) on a terminal's stderr, or None where there is none."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    try:
        from tqdm import tqdm
    except ImportError:
        yield None
        return
    # A serial line or a container's console may not know its width.
    width = os.get_terminal_size(sys.stderr.fileno()).columns or 80
    form = "{desc} {percentage:3.0f}% |{bar}| {elapsed}"
    with tqdm(total=1.0, desc=label, leave=False, ncols=width, bar_format=form) as bar:
        yield lambda share: bar.update(share - bar.n)


# accuracy


def _prepare_accuracy(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("mold", metavar="INPUT", help="as for render")
    parser.add_argument(
        "-o", "--output", required=True, metavar="FOLDER", help="for prices.csv .json .png .svg and crops.png"
    )
    _add_view_options(parser)
    parser.add_argument(
        "--seconds", type=float, default=SECONDS, metavar="S", help=f"what a point may take ({SECONDS:g})"
    )
    parser.add_argument("--measure", action="store_true", help="render the points, beside the prediction")
    _add_report_options(parser)


def _accuracy(options: argparse.Namespace) -> None:
    folder = writable_folder(options.output)
    _check_files(options, [])
    _check_positive(options, "scale", "finish_height", "seconds", "threads")
    scene = _scene(options)
    prices = _cancellable("pricing", options, accuracy, scene, seconds=options.seconds, measure=options.measure)
    prices.save(folder)
    _answer(options, prices.to_json() | {"input": _input(options.mold)}, _told_of_prices(prices))


def _told_of_prices(prices: PriceList) -> str:
    lines = [f"{'':28}{'seconds':>9}{'error':>10}" + (f"{'measured':>12}{'error':>10}" if prices.reference else "")]
    for price in prices.prices:
        line = f"{price.name:28}{price.predicted_seconds:>9.3g}{price.predicted_error:>10.2g}"
        if price.seconds is not None:
            wrong = "" if price.error is None else f"{price.error:.2g}"
            line += f"{price.seconds:>12.3g}{wrong:>10}"
        lines.append(line)
    return "\n".join(lines)


# glasses and stations


PREVIEW_SECONDS = 5.0
PREVIEW_SIDE = 320


def _prepare_glasses(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", nargs="?", metavar="NAME", help="tell all of this one, or of one in a file")
    parser.add_argument(
        "--swatches", metavar="PICTURE", help="draw the colours against the wall thickness: .png .svg .pdf"
    )
    parser.add_argument("--plot", metavar="PICTURE", help="draw what each wavelength passes: .png .svg .pdf")
    parser.add_argument("--json", action="store_true", help="answer in JSON")


def _glasses(options: argparse.Namespace) -> None:
    glasses, liquids = catalogue(), fillings()
    if options.name is not None:
        material = _material(options.name, liquids)
        glasses = {material.name: material} if isinstance(material, Glass) else {}
        liquids = {} if glasses else {material.name: material}
    if options.swatches is not None:
        save_swatches(glasses, liquids, check_drawing(options.swatches, SWATCHES))
    if options.plot is not None:
        save_curves(glasses, liquids, check_drawing(options.plot, CURVES))
    if options.json:
        groups = {"glasses": glasses, "fillings": liquids}
        told = {group: [facts(material) for material in known.values()] for group, known in groups.items()}
        print(_json(told | ({"refused": refused()} if options.name is None else {})))
    elif options.swatches is not None or options.plot is not None:
        return
    elif options.name is not None:
        print("\n".join(in_words(next(iter((glasses or liquids).values())))))
    else:
        _list_materials("glasses", glasses, 3.0)
        for name, why in refused().items():
            print(f"  {name:17} refused: {why}")
        _list_materials("fillings", liquids, 60.0)


def _material(name: str, liquids: Mapping[str, Filling]) -> Glass | Filling:
    """Return a glass or a filling by its name, whichever has it."""
    if name.partition(" ")[0] in liquids:
        return find_filling(name)
    return find_glass(name)


def _list_materials(group: str, known: Mapping[str, Glass | Filling], path_mm: float) -> None:
    print(f"{group:19} n_d      g/cm3  {path_mm:g} mm")
    for material in known.values():
        index, density = material.refractive_index_d, material.density_g_per_cm3
        colour = shown_colour(material, path_mm)
        print(f"  {material.name:17} {index:.5f}  {density:.3f}  {colour}  {material.description}")


def _prepare_stations(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="answer in JSON")
    parser.add_argument(
        "--preview",
        metavar="S",
        help="draw this station instead, with a tumbler: where camera and light stand, and what is seen",
    )
    parser.add_argument("-o", "--output", metavar="PICTURE", help="where to draw it: .png .svg .pdf")


def _stations(options: argparse.Namespace) -> None:
    if (options.preview is None) != (options.output is None):
        raise InputError("--preview and -o belong together; give both, as --preview studio -o studio.png")
    if options.preview is not None:
        output = check_drawing(options.output, LAYOUT)
        scene = station(options.preview, sample_container(), "flint")
        seen = dataclasses.replace(scene, size=_preview_size(scene.size))
        title = f"{options.preview}: {described(options.preview)}"
        save_layout(scene, render(seen, seconds=PREVIEW_SECONDS).display(), title, output)
        return
    known = stations()
    width = max(map(len, known))
    print(_json(known) if options.json else "\n".join(f"{name:{width}} {what}" for name, what in known.items()))


def _preview_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return a size of the same shape whose longer side is `PREVIEW_SIDE` pixels."""
    share = PREVIEW_SIDE / max(size)
    return max(1, round(share * size[0])), max(1, round(share * size[1]))


# compare


def _prepare_compare(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("golden", metavar="GOLDEN", help="golden image, or a rendering of a station (.exr)")
    parser.add_argument("image", metavar="IMAGE", help="of the camera: .png .tif of 8 to 16 bits, or .exr")
    parser.add_argument("--limits", metavar="L.toml", help="from which size on a finding is of which class")
    parser.add_argument("--tone", metavar="TONE", help="of the camera's values: linear or sRGB (linear)")
    parser.add_argument("--overlay", metavar="PICTURE", help="draw what was found: .png .svg .pdf")
    _add_report_options(parser)


def _compare(options: argparse.Namespace) -> None:
    from glassworkbench.judging import compare, save_overlay
    from glassworkbench.judging.overlay import OVERLAY

    read = {Path(path).resolve() for path in (options.golden, options.image, options.limits) if path is not None}
    outputs = []
    if options.overlay is not None:
        outputs.append(check_drawing(options.overlay, OVERLAY))
    if options.report is not None:
        outputs.append(check_writable(options.report))
    for path in outputs:
        if path.resolve() in read:
            raise InputError(f"{path}: it is read from, and would be overwritten; name another file to write to")
    for path in (options.golden, options.image):
        _check_input(path)
    started = time.perf_counter()
    told = compare(options.golden, options.image, limits=options.limits, tone=options.tone)
    if options.overlay is not None:
        save_overlay(told, Path(options.image).name, options.overlay)
    report = told.to_json() | {
        "golden": _input(options.golden),
        "image": _input(options.image),
        "seconds": round(time.perf_counter() - started, 3),
        "version": __version__,
    }
    _answer(options, report, f"{options.image}: {_told_of_comparison(report)}")


def _told_of_comparison(report: Mapping) -> str:
    told = [report["verdict"]]
    for zone in report["zones"]:
        counts = [f"{zone[name]} {name}" for name in ("critical", "major", "minor") if zone[name]]
        if counts:
            told.append(f"{zone['name']} {' and '.join(counts)}")
    found = report["registration"]
    right, down = found["shift_px"]
    moved = f"shift {right:.2f}, {down:.2f} px, rotation {found['rotation_deg']:.3f} deg, scale {found['scale']:.4f}"
    return f"{', '.join(told)} ({moved}, gain {found['gain']:.3f})"


# defects


def _prepare_defects(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", nargs="?", metavar="NAME", help="tell what can be said of this kind")
    parser.add_argument("--json", action="store_true", help="answer in JSON")


def _defects(options: argparse.Namespace) -> None:
    if options.name is not None:
        told = described_defect(options.name)
        print(_json(told) if options.json else "\n".join(f"{key:18} {value}" for key, value in told.items()))
    elif options.json:
        print(_json({"kinds": kinds(), "populations": populations()}))
    else:
        for group, known in (("kinds", kinds()), ("populations", populations())):
            print(group)
            for name, what in known.items():
                print(f"  {name:14} {what}")


# what verbs share


def _add_report_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--report", metavar="R.json", help="write what was done and what it cost")
    parser.add_argument("--json", action="store_true", help="answer with that report")


def _check_files(options: argparse.Namespace, outputs: Sequence[Path]) -> None:
    """Check the input, and that nothing that is read, and no other output, would be overwritten."""
    _check_input(options.mold)
    outputs = list(outputs) if options.report is None else [*outputs, check_writable(options.report)]
    read = [options.mold]
    if (options.wall or "").startswith("@"):
        from glassworkbench.wall.asking.thickness_text import table_file

        read.append(table_file(options.wall))
    if getattr(options, "defects", None):
        read.append(options.defects)
    taken = {Path(path).resolve(): "it is read from, and would be overwritten" for path in read}
    for path in outputs:
        if path.resolve() in taken:
            raise InputError(f"{path}: {taken[path.resolve()]}; name another file to write to")
        taken[path.resolve()] = "two outputs have this name"


def _check_input(path: str) -> None:
    if Path(path).is_dir():
        raise InputError(f"{path}: it is a folder; name a file in it")


def _check_positive(options: argparse.Namespace, *names: str) -> None:
    for name in names:
        value = getattr(options, name)
        if value is not None and not 0 < value < math.inf:
            raise InputError(f"--{name.replace('_', '-')}: must be above 0, got {value:g}")


def _answer(options: argparse.Namespace, report: Mapping, sentence: str) -> None:
    if options.report is not None:
        _write_report(options.report, report)
    if options.json:
        print(_json(report))
    elif not options.quiet:
        print(sentence)


def _write_report(path: str, report: Mapping) -> None:
    with written_aside(path) as aside:
        aside.write_text(_json(report) + "\n", encoding="utf-8")


def _input(path: str) -> dict[str, str]:
    return {"path": str(path), "sha256": hashlib.sha256(Path(path).read_bytes()).hexdigest()}


def _json(value: object) -> str:
    return json.dumps(_plain(value), indent=2, ensure_ascii=False, allow_nan=False)


def _plain(value: object) -> object:
    """Return what JSON can hold: lists for arrays, None for what is not finite."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


_VERBS = {
    "inspect": (_prepare_inspect, _inspect, "say what a mold file holds", "bottle.step"),
    "hollow": (_prepare_hollow, _hollow, "give a mold a wall", "bottle.step --wall 3 -o container.step"),
    "render": (
        _prepare_render,
        _render,
        "show what light makes of a container",
        "bottle.step --wall 3 --glass emerald --station studio -o bottle.png",
    ),
    "accuracy": (
        _prepare_accuracy,
        _accuracy,
        "show what accuracy costs: error against seconds",
        "bottle.step --wall 3 --measure -o prices",
    ),
    "compare": (
        _prepare_compare,
        _compare,
        "hold a camera's image against a golden one",
        "golden.exr camera.png --report r.json --overlay o.png",
    ),
    "glasses": (_prepare_glasses, _glasses, "list the glasses and the liquids that fill them", "--json"),
    "stations": (
        _prepare_stations,
        _stations,
        "list the stations where a container is seen",
        "--preview studio -o studio.png",
    ),
    "defects": (
        _prepare_defects,
        _defects,
        "list the kinds of defects, and the populations they are drawn from",
        "stone",
    ),
}


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
