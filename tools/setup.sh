#!/bin/sh
# Installs what a Debian or Ubuntu machine lacks to build, run and test GlassWorkbench. Does nothing when all is there.
set -eu

packages="
    freecad python3-numpy python3-openimageio python3-tqdm
    g++ cmake make
    python3-pytest python3-hypothesis python3-scipy python3-skimage python3-matplotlib
    xvfb xauth x11-utils imagemagick libgl1-mesa-dri
    clang-format python3-venv
"

installed=$(dpkg-query -W -f '${Package}=${db:Status-Status} ' $packages 2>/dev/null || true)
missing=""
for package in $packages; do
    case " $installed" in
        *" $package=installed "*) ;;
        *) missing="$missing $package" ;;
    esac
done
[ -n "$missing" ] || exit 0

if ! command -v apt-get >/dev/null; then
    echo "setup: this is no Debian or Ubuntu; install by hand what matches:$missing" >&2
    exit 1
fi
as_root=""
if [ "$(id -u)" -ne 0 ]; then
    as_root="sudo"
fi
echo "setup: installing$missing"
$as_root apt-get update -q
DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -q --no-install-recommends $missing </dev/null
