"""From a mold to a picture; runs in FreeCAD's macro editor, in freecadcmd, and in FreeCAD's own Python."""

import glassworkbench as gw

mold = gw.read_mold("examples/molds/wine_bottle.step")
container = gw.hollow(mold, "finish=3 body=2.5 heel=4 base=5")
scene = gw.station("studio", container.geometry(), glass="emerald", fill="water:180", size=(240, 320))
image = gw.render(scene, seconds=5)
image.save("bottle.png")
