import ctypes
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import nullcontext
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


def exhaust_memory_in_occ(shape):
    return [Part.Compound([shape.copy() for _ in range(10_000_000)])]


def hit_a_forbidden_address(shape):
    ctypes.string_at(0)


def leave_litter(shape, fate):
    tempfile.mkdtemp(prefix="litter-")
    Path(tempfile.mkstemp()[1]).write_text("litter")
    {"ends": list, "crashes": os.abort, "hangs": signal.pause}[fate]()
    return []


def tell_pid_and_wait(shape, note):
    Path(note).write_text(str(os.getpid()))
    time.sleep(600)


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


def test_memory_that_occ_exhausts_is_told_as_such():
    with pytest.raises(GlassWorkbenchError, match=r"needs more than 1\.0 GB of memory"):
        run_in_worker(exhaust_memory_in_occ, [Part.makeBox(1, 1, 1)], {}, 60.0, 1 << 30)


def test_a_segmentation_fault_is_a_crash():
    with pytest.raises(GlassWorkbenchError, match=r"^the worker process crashed \(SIGSEGV\)$"):
        run_in_worker(hit_a_forbidden_address, [Part.makeBox(1, 1, 1)], {}, 60.0)


@pytest.mark.parametrize("fate", ["ends", "crashes", "hangs"])
def test_no_temporary_file_stays(fate, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with nullcontext() if fate == "ends" else pytest.raises(GlassWorkbenchError, match=r"^[^\n]+$"):
        run_in_worker(leave_litter, [Part.makeBox(1, 1, 1)], {"fate": fate}, 4.0)
    assert list(tmp_path.iterdir()) == []


def test_a_worker_whose_parent_was_killed_ends_by_itself(tmp_path, monkeypatch):
    note = tmp_path / "pid"
    program = (
        f"import sys; sys.path[:0] = {[str(Path(__file__).parent), str(Path(worker.__file__).parents[2])]!r}\n"
        "import test_wall_worker as t\n"
        "t.worker.GRACE_SECONDS = 0.0\n"
        f"t.run_in_worker(t.tell_pid_and_wait, [], {{'shape': None, 'note': {str(note)!r}}}, 5.0)\n"
    )
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    parent = subprocess.Popen([sys.executable, "-c", program])
    deadline = time.monotonic() + 30.0
    while not (note.exists() and note.read_text()) and time.monotonic() < deadline:
        time.sleep(0.05)
    parent.kill()
    parent.wait()
    pid = note.read_text()
    deadline = time.monotonic() + 20.0
    while is_running(pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not is_running(pid)


def test_a_package_of_the_same_name_in_the_working_directory_is_not_taken(tmp_path, monkeypatch):
    (tmp_path / "glassworkbench").mkdir()
    (tmp_path / "glassworkbench" / "__init__.py").write_text("raise SystemExit(3)")
    monkeypatch.chdir(tmp_path)
    (solid,) = run_in_worker(fuse, [Part.makeBox(1, 1, 1), Part.makeBox(1, 1, 1)], {"shift_mm": 1.0}, 60.0)
    assert solid.Volume == pytest.approx(2.0)


def test_a_failure_says_why():
    with pytest.raises(GlassWorkbenchError, match="the offset is empty"):
        run_in_worker(fail, [Part.makeBox(1, 1, 1)], {}, 60.0)


def test_python_is_found_when_embedded_in_freecad(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/usr/bin/freecadcmd")
    version = subprocess.run([worker.interpreter(), "-V"], capture_output=True, text=True, check=True).stdout
    assert version.startswith(f"Python {sys.version_info.major}.{sys.version_info.minor}.")
