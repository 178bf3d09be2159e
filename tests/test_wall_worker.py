import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import Part
from glassworkbench.wall import worker
from glassworkbench.wall.worker import run_in_worker


def fuse(first, second, shift_mm):
    second.translate((shift_mm, 0, 0))
    return [first.fuse(second)]


def hang(shape, note):
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    Path(note).write_text(f"{os.getpid()} {child.pid}")
    time.sleep(600)


def crash(shape):
    os.abort()


def exhaust_memory(shape):
    return [bytearray(8 << 30)]


def fail(shape):
    raise ValueError("the offset is empty")


def is_running(pid):
    try:
        return "zombie" not in Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


def test_shapes_go_in_and_come_out():
    (solid,) = run_in_worker(fuse, [Part.makeBox(1, 1, 1), Part.makeBox(1, 1, 1)], {"shift_mm": 1.0}, 60.0)
    assert solid.Volume == pytest.approx(2.0)


def test_a_hanging_job_is_killed_with_its_children(tmp_path):
    note = tmp_path / "pids"
    start = time.monotonic()
    with pytest.raises(GlassWorkbenchError, match="did not finish within 8 s"):
        run_in_worker(hang, [Part.makeBox(1, 1, 1)], {"note": str(note)}, 8.0)
    assert time.monotonic() - start < 20.0
    deadline = time.monotonic() + 5.0
    pids = note.read_text().split()
    while any(map(is_running, pids)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(is_running, pids))


def test_a_crash_is_reported_by_its_signal():
    with pytest.raises(GlassWorkbenchError, match=r"crashed.*SIGABRT"):
        run_in_worker(crash, [Part.makeBox(1, 1, 1)], {}, 60.0)


def test_memory_is_limited():
    with pytest.raises(GlassWorkbenchError, match="memory"):
        run_in_worker(exhaust_memory, [Part.makeBox(1, 1, 1)], {}, 60.0)


def test_a_failure_says_why():
    with pytest.raises(GlassWorkbenchError, match="the offset is empty"):
        run_in_worker(fail, [Part.makeBox(1, 1, 1)], {}, 60.0)


def test_python_is_found_when_embedded_in_freecad(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/usr/bin/freecadcmd")
    version = subprocess.run([worker.interpreter(), "-V"], capture_output=True, text=True, check=True).stdout
    assert version.startswith(f"Python {sys.version_info.major}.{sys.version_info.minor}.")
