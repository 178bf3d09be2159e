"""Runs one function on OCC shapes in a process of its own, which may hang or crash without harm.

As a program, ``python -m glassworkbench.wall.worker FOLDER`` does the job that lies in the folder.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from glassworkbench.errors import GlassWorkbenchError

if TYPE_CHECKING:
    import Part

MEMORY_BYTES = 4 << 30
"""What a job may allocate (address space) where the system can limit it."""


def run_in_worker(
    function: Callable[..., Sequence[Part.Shape]],
    shapes: Sequence[Part.Shape],
    arguments: dict[str, object],
    seconds: float,
    memory_bytes: int = MEMORY_BYTES,
) -> list[Part.Shape]:
    """Return ``function(*shapes, **arguments)``, computed in another process.

    Parameters
    ----------
    function : callable
        Found by its module and name on the other side; takes shapes and returns shapes.
    shapes : sequence of Part.Shape
    arguments : dict
        Anything that JSON can hold.
    seconds : float
        After this time the process and its children are killed.
    memory_bytes : int

    Raises
    ------
    GlassWorkbenchError
        If the function fails, crashes, or does not finish in time; the message says which.
    """
    from glassworkbench.freecad import Part

    with tempfile.TemporaryDirectory(prefix="glassworkbench-") as name:
        folder = Path(name)
        for number, shape in enumerate(shapes):
            shape.exportBrep(str(folder / f"in{number}.brep"))
        job = {
            "module": function.__module__,
            "function": function.__qualname__,
            "shapes": len(shapes),
            "arguments": arguments,
            "memory_bytes": memory_bytes,
            "path": sys.path,
        }
        (folder / "job.json").write_text(json.dumps(job), encoding="utf-8")
        exit_code = _wait(folder, seconds)
        result = folder / "result.json"
        if not result.exists():
            raise GlassWorkbenchError(f"the worker process crashed ({_death(exit_code)})")
        answer = json.loads(result.read_text(encoding="utf-8"))
        if "error" in answer:
            raise GlassWorkbenchError(answer["error"])
        outputs = []
        for number in range(answer["shapes"]):
            shape = Part.Shape()
            shape.read(str(folder / f"out{number}.brep"))
            outputs.append(shape)
        return outputs


def interpreter() -> str:
    """Return the Python that can load FreeCAD: this one, also where it is embedded in FreeCAD's programs.

    Raises
    ------
    GlassWorkbenchError
        If there is none beside this program.
    """
    names = [f"python{sys.version_info.major}.{sys.version_info.minor}", "python3", "python", "python.exe"]
    if Path(sys.executable or "").name.lower().startswith("python"):
        return sys.executable
    folders = [Path(sys.base_exec_prefix) / "bin", Path(sys.base_exec_prefix), Path(sys.executable or ".").parent]
    for name in names:
        for folder in folders:
            if (folder / name).is_file():
                return str(folder / name)
    found = next(filter(None, map(shutil.which, names[:1])), None)
    if found is None:
        raise GlassWorkbenchError(f"no {names[0]} found beside {sys.executable}; install FreeCAD's Python interpreter")
    return found


def _wait(folder: Path, seconds: float) -> int:
    """Run the worker on a folder and return its exit code; kill it and its children when the time is over."""
    package_root = str(Path(__file__).resolve().parents[2])
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([package_root, os.environ.get("PYTHONPATH", "")])}
    with (folder / "output.txt").open("wb") as output:
        process = subprocess.Popen(
            [interpreter(), "-m", "glassworkbench.wall.worker", str(folder)],
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
            env=environment,
            start_new_session=True,
        )
        try:
            return process.wait(timeout=max(seconds, 0.0))
        except subprocess.TimeoutExpired as error:
            _kill(process)
            raise GlassWorkbenchError(f"it did not finish within {seconds:.0f} s and was stopped") from error
        except BaseException:
            _kill(process)
            raise


def _kill(process: subprocess.Popen) -> None:
    if os.name == "posix":
        # The worker leads a session of its own, so its children go with it.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    else:
        subprocess.run(["taskkill", "/F", "/T", "/PID", str(process.pid)], capture_output=True, check=False)
    process.wait()


def _death(exit_code: int) -> str:
    if exit_code >= 0:
        return f"exit code {exit_code}"
    try:
        return signal.Signals(-exit_code).name
    except ValueError:
        return f"signal {-exit_code}"


def _work(folder: Path) -> None:
    from glassworkbench.freecad import Part

    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    sys.path.extend(entry for entry in job["path"] if entry not in sys.path)
    _limit_memory(job["memory_bytes"])
    try:
        function = getattr(importlib.import_module(job["module"]), job["function"])
        shapes = []
        for number in range(job["shapes"]):
            shape = Part.Shape()
            shape.read(str(folder / f"in{number}.brep"))
            shapes.append(shape)
        outputs = function(*shapes, **job["arguments"])
        for number, shape in enumerate(outputs):
            shape.exportBrep(str(folder / f"out{number}.brep"))
        answer = {"shapes": len(outputs)}
    except MemoryError:
        answer = {"error": f"it needs more than {job['memory_bytes'] / (1 << 30):.1f} GB of memory"}
    # Part.OCCError and friends derive from Exception only; whatever fails here is an outcome for the parent to report.
    except Exception as error:
        traceback.print_exc()
        answer = {"error": str(error) or type(error).__name__}
    aside = folder / "result.json.part"
    aside.write_text(json.dumps(answer), encoding="utf-8")
    aside.rename(folder / "result.json")


def _limit_memory(memory_bytes: int) -> None:
    try:
        import resource
    except ImportError:
        # Windows has no such limit; the time limit remains.
        return
    resource.setrlimit(resource.RLIMIT_AS, (memory_bytes, memory_bytes))


if __name__ == "__main__":
    start = time.monotonic()
    _work(Path(sys.argv[1]))
    print(f"{time.monotonic() - start:.2f} s")
