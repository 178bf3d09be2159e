#!/usr/bin/python3
"""Runs all tests on FreeCAD 0.20, 1.0 and 1.1, one Debian release each, and writes docs/compat.md.

Debian 12 is this machine; the others live in folders that this makes (as root, about 2 GB each) and keeps.
"""

from __future__ import annotations

import datetime
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parent.parent
CACHE = Path("/var/cache/glassworkbench")
COPY = Path("/var/tmp/glassworkbench-compat")
"""Where the checkout is copied to, seen from inside each release: builds share nothing."""

VERSIONS = """
import platform, sys
import glassworkbench.freecad
import FreeCAD, Part, numpy, OpenImageIO
try:
    from PySide6 import QtCore
except ImportError:
    from PySide2 import QtCore
occ = getattr(Part, "OCC_VERSION", "") or FreeCAD.ConfigGet("OCC_VERSION")
freecad = ".".join(FreeCAD.Version()[:3]).split(" ")[0]
others = QtCore.qVersion(), occ, OpenImageIO.VERSION_STRING, numpy.__version__
print(freecad, platform.python_version(), *others, sep="|")
"""


@dataclass(frozen=True)
class Result:
    """How the tests fared on one release."""

    release: str
    versions: list[str]
    counts: dict[str, int]
    seconds: float


def main() -> int:
    """Test every release and return 0 if no test failed anywhere."""
    commit = output("git", "-C", str(CHECKOUT), "describe", "--always", "--dirty").strip()
    roots = {"bookworm": Path("/"), "trixie": CACHE / "trixie", "forky": CACHE / "forky"}
    for release, root in roots.items():
        if release != "bookworm":
            install(release, root)
    with ThreadPoolExecutor() as pool:
        results = list(pool.map(test, roots, roots.values()))
    write_table(results, commit)
    return int(any(result.counts.get(word) for result in results for word in ("failed", "error", "errors")))


def install(release: str, root: Path) -> None:
    """Make a Debian release in a folder, unless it is there, and mount what programs in it need."""
    if not (root / ".ready").exists():
        print(f"compat: installing Debian {release} into {root}", flush=True)
        command("apt-get", "install", "-y", "-q", "debootstrap")
        sources = output("apt-get", "indextargets", "--format", "$(REPO_URI)", "Created-By: Packages")
        # debootstrap of Debian 12 has no script for releases after trixie; trixie's serves.
        command("debootstrap", "--variant=minbase", release, root, sources.split()[0], script_for(release))
        (root / "etc/apt/apt.conf.d/99compat").write_text('Acquire::Check-Valid-Until "false";\n')
        (root / ".ready").touch()
    for folder in ("proc", "dev", "dev/pts"):
        if subprocess.run(["mountpoint", "-q", root / folder]).returncode != 0:
            command("mount", "--bind", f"/{folder}", root / folder)


def script_for(release: str) -> str:
    """Return the path of debootstrap's script for a release."""
    scripts = Path("/usr/share/debootstrap/scripts")
    return str(scripts / (release if (scripts / release).exists() else "trixie"))


def test(release: str, root: Path) -> Result:
    """Copy the checkout into a release, build it there and run its tests."""
    print(f"compat: testing on {release}", flush=True)
    copy = root / COPY.relative_to("/")
    subprocess.run(["rm", "-rf", copy], check=True)
    copy.mkdir(parents=True)
    files = "git ls-files -z --cached --others --exclude-standard | tar --null --ignore-failed-read -cf - -T -"
    subprocess.run(f"{files} | tar -xf - -C '{copy}'", shell=True, check=True, cwd=CHECKOUT)
    inside(root, "tools/setup.sh && make build")
    versions = inside(root, f"PYTHONPATH=. /usr/bin/python3 -c '{VERSIONS}'").strip().splitlines()[-1].split("|")
    started = time.perf_counter()
    closing = inside(root, "/usr/bin/python3 -m pytest -p no:cacheprovider -q || true").strip().splitlines()[-1]
    counts = {word: int(number) for number, word in re.findall(r"(\d+) (passed|failed|skipped|errors?)", closing)}
    if not counts:
        # FreeCAD turns a crash into a silent exit: no closing line then.
        counts = {"failed": 1}
        print(f"compat: the tests died on {release}", flush=True)
    return Result(release, versions, counts, time.perf_counter() - started)


def inside(root: Path, line: str) -> str:
    """Run a shell line in the copy inside a release, show what it prints, and return that."""
    environment = ["env", "-i", "HOME=/root", "LANG=C.UTF-8", "PATH=/usr/sbin:/usr/bin:/sbin:/bin", "NO_COLOR=1"]
    whole = ["chroot", root, *environment, "sh", "-c", f"cd {COPY} && {line}"]
    with subprocess.Popen(whole, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as process:
        lines = []
        for text in process.stdout:
            print(f"{root.name or 'bookworm'}: {text}", end="", flush=True)
            lines.append(text)
    if process.returncode != 0:
        sys.exit(f"compat: failed in {root}: {line}")
    return "".join(lines)


def command(*words: object) -> None:
    """Run a program and stop if it fails."""
    subprocess.run([str(word) for word in words], check=True, stdin=subprocess.DEVNULL)


def output(*words: str) -> str:
    """Return what a program prints."""
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def write_table(results: list[Result], commit: str) -> None:
    """Write docs/compat.md: how the tests fared, and on which commit."""
    lines = [
        "# On which FreeCADs the tests pass",
        "",
        f"Written by `make compat` on {datetime.date.today().isoformat()} at commit {commit}. All tests, the window's "
        "under Xvfb included.",
        "",
        "| Debian | FreeCAD | Python | Qt | OCC | OpenImageIO | numpy | passed | failed | skipped | seconds |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for result in results:
        failed = result.counts.get("failed", 0) + result.counts.get("error", 0) + result.counts.get("errors", 0)
        numbers = [result.counts.get("passed", 0), failed, result.counts.get("skipped", 0), round(result.seconds)]
        lines.append("| " + " | ".join([result.release, *result.versions, *map(str, numbers)]) + " |")
    (CHECKOUT / "docs" / "compat.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    sys.exit(main())
