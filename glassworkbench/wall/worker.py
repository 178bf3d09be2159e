"""Runs one function in a process of its own, which may hang or crash without harm.

The other process calls `work` on the folder that the job lies in.
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
import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from glassworkbench.errors import GlassWorkbenchError, InputError, OutOfTimeError
from glassworkbench.wall.parcel import pack, unpack

MEMORY_BYTES = 4 << 30
"""What a job may allocate (address space) where the system can limit it."""

ARGUMENTS, RESULT, OUTPUT = "arguments.pickle", "result.pickle", "output.txt"
"""Where a job's arguments, its result and what it prints go, in its folder."""

OUT_OF_MEMORY = ("bad_alloc", "OutOfMemory", "MemoryError")
"""What C++, OCC and Python write when an allocation fails."""

STARVED_SHARE, FULL_SHARE = 0.5, 0.95
"""A job that has filled this share of its memory, or of its address space, which code is a part of, and fails is taken
to have wanted more."""

GRACE_SECONDS = 5.0
"""A job whose parent is gone ends by itself this much after its time."""


def run_in_worker(
    function: Callable[..., Any],
    arguments: Sequence[object],
    named_arguments: Mapping[str, object],
    seconds: float,
    memory_bytes: int = MEMORY_BYTES,
) -> Any:
    """Return ``function(*arguments, **named_arguments)``, computed in another process.

    Parameters
    ----------
    function : callable
        Found by its module and name on the other side.
    arguments, named_arguments : sequence, mapping
        Like the answer, data that can be pickled, and OCC shapes in it.
    seconds : float
        After this time the process and its children are killed.
    memory_bytes : int

    Raises
    ------
    InputError
        If the function raises one.
    GlassWorkbenchError
        If the function fails, crashes, or does not finish in time; the message says which. Where the function raises
        one of a kind of its own, it is of that kind.
    """
    with tempfile.TemporaryDirectory(prefix="glassworkbench-") as name:
        folder = Path(name)
        job = {
            "module": function.__module__,
            "function": function.__qualname__,
            "memory_bytes": memory_bytes,
            "lifetime_seconds": seconds + GRACE_SECONDS,
            "path": sys.path,
        }
        (folder / "job.json").write_text(json.dumps(job), encoding="utf-8")
        (folder / ARGUMENTS).write_bytes(pack((tuple(arguments), dict(named_arguments))))
        exit_code = _wait(folder, seconds)
        result = folder / RESULT
        if not result.exists():
            raise GlassWorkbenchError(f"the worker process {_death(exit_code, folder / OUTPUT, memory_bytes)}")
        answer, error = unpack(result.read_bytes())
        if error is not None:
            raise error
        return answer


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
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([package_root, os.environ.get("PYTHONPATH", "")]),
        # The worker takes its code from here, also where another copy lies in the working directory.
        "PYTHONSAFEPATH": "1",
        # What a killed worker leaves behind goes with the folder.
        **dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(folder)),
    }
    with (folder / OUTPUT).open("wb") as output:
        process = subprocess.Popen(
            [interpreter(), "-c", f"from {__name__} import work; work({str(folder)!r})"],
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
            raise OutOfTimeError(f"it did not finish within {seconds:.3g} s and was stopped") from error
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


def _death(exit_code: int, output: Path, memory_bytes: int) -> str:
    """Return how a worker ended that left no result, as the end of a sentence."""
    told = output.read_text(encoding="utf-8", errors="replace").strip()
    if any(sign in told for sign in OUT_OF_MEMORY):
        return _too_much(memory_bytes)
    if exit_code >= 0:
        return f"crashed (exit code {exit_code}: {told.splitlines()[-1] if told else 'it told nothing'})"
    try:
        return f"crashed ({signal.Signals(-exit_code).name})"
    except ValueError:
        return f"crashed (signal {-exit_code})"


def work(name: str) -> None:
    """Do the job that lies in a folder, and leave its result there."""
    folder = Path(name)
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    sys.path.extend(entry for entry in job["path"] if entry not in sys.path)
    _die_of_crashes()
    _limit_memory(job["memory_bytes"])
    _limit_time(job["lifetime_seconds"])
    try:
        function = getattr(importlib.import_module(job["module"]), job["function"])
        arguments, named_arguments = unpack((folder / ARGUMENTS).read_bytes())
        result = pack((function(*arguments, **named_arguments), None))
    except InputError as error:
        result = pack((None, error))
    # Part.OCCError and friends derive from Exception only; whatever fails here is an outcome for the parent to report.
    except Exception as error:
        traceback.print_exc()
        # FreeCAD says of an allocation that failed in C++ only that an exception is unknown.
        starved = isinstance(error, MemoryError) or _has_starved(job["memory_bytes"])
        if isinstance(error, GlassWorkbenchError) and not starved:
            result = pack((None, error))
        else:
            why = f"it {_too_much(job['memory_bytes'])}" if starved else str(error).strip() or type(error).__name__
            result = pack((None, GlassWorkbenchError(why)))
    aside = folder / f"{RESULT}.part"
    aside.write_bytes(result)
    aside.rename(folder / RESULT)


def _too_much(memory_bytes: int) -> str:
    return f"needs more than {memory_bytes / (1 << 30):.1f} GB of memory"


def _die_of_crashes() -> None:
    """Undo FreeCAD's handlers, which hide by which signal a process dies."""
    for name in ("SIGSEGV", "SIGABRT", "SIGFPE", "SIGILL", "SIGBUS"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)


def _limit_time(seconds: float) -> None:
    # The signal's default action ends the process also while OCC computes, where no Python code runs.
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds)


def _limit_memory(memory_bytes: int) -> None:
    try:
        import resource
    except ImportError:
        # Windows has no such limit; the time limit remains.
        return
    resource.setrlimit(resource.RLIMIT_AS, (memory_bytes, memory_bytes))


def _has_starved(memory_bytes: int) -> bool:
    try:
        import resource
    except ImportError:
        return False
    # In kilobytes, but on macOS in bytes.
    filled = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    return filled > STARVED_SHARE * memory_bytes or _most_address_space_bytes() > FULL_SHARE * memory_bytes


def _most_address_space_bytes() -> int:
    """Return the most address space, which the limit is on, that this process has had; 0 where no file tells."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
            if line.startswith("VmPeak:"):
                return 1024 * int(line.split()[1])
    return 0
