#!/bin/sh
# The main job on a real mold: a wine bottle, hollowed and seen in the studio and on the line.
set -eu
cd "$(dirname "$0")/.."

mold=examples/molds/wine_bottle.step
mkdir -p out/demo
bin/glassworkbench hollow $mold --wall 3 -o out/demo/container.step --report out/demo/wall.json
bin/glassworkbench render $mold --wall 3 --glass emerald --station studio --size 480x640 -o out/demo/studio.png
bin/glassworkbench render $mold --wall 3 --glass emerald --station sidewall --size 480x640 \
    -o out/demo/sidewall.png -o out/demo/sidewall.exr
echo "The demo is in $PWD/out/demo:"
ls out/demo
