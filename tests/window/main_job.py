"""A designer's first hour in the window: container, glass, picture, undo, another wall, save, reopen, cancel."""

import sys
import time
from pathlib import Path

import FreeCAD
import FreeCADGui
import numpy as np
import Part
from PySide import QtCore, QtGui

sys.path.insert(0, str(Path(__file__).resolve().parent))
from steps import (
    CHECKOUT,
    FOLDER,
    QtWidgets,
    Runner,
    child,
    later,
    on_screen,
    open_dialog,
    screenshot,
    task_panel_button,
)


def main_job(facts):
    window = FreeCADGui.getMainWindow()
    facts["version"] = FreeCAD.Version()[:3]
    yield lambda: window.isVisible()

    FreeCADGui.activateWorkbench("GlassWorkbench")
    yield lambda: FreeCADGui.activeWorkbench().name() == "GlassWorkbench"
    facts["workbench_icon"] = Path(FreeCADGui.activeWorkbench().Icon).is_file()
    facts["menu"] = [action.text() for action in window.menuBar().actions()]
    yield lambda: any(toolbar.windowTitle() == "Glass" for toolbar in window.findChildren(QtWidgets.QToolBar))
    toolbar = next(bar for bar in window.findChildren(QtWidgets.QToolBar) if bar.windowTitle() == "Glass")
    facts["toolbar"] = {
        action.text(): not action.icon().isNull() for action in toolbar.actions() if not action.isSeparator()
    }

    document = FreeCAD.newDocument("Bottle")
    document.UndoMode = 1
    Part.insert(str(CHECKOUT / "examples" / "molds" / "wine_bottle.step"), "Bottle")
    mold = document.Objects[0]
    document.recompute()
    FreeCADGui.activeDocument().activeView().viewFront()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    facts["active_without_selection"] = FreeCADGui.Command.get("Glass_MakeContainer").isActive()
    FreeCADGui.Selection.addSelection(mold)
    facts["active_with_solid"] = FreeCADGui.Command.get("Glass_MakeContainer").isActive()
    facts["render_active_with_solid"] = FreeCADGui.Command.get("Glass_Render").isActive()

    # A wall that cannot be: one sentence, and nothing changes.
    FreeCADGui.runCommand("Glass_MakeContainer")
    yield lambda: task_panel_button("Ok")
    child(window, "wall").setText("body=2 knee=3")
    objects_before = len(document.Objects)
    later(task_panel_button("Ok").click)
    yield lambda: QtWidgets.QApplication.activeModalWidget()
    facts["dialog_of_bad_wall"] = open_dialog()
    yield lambda: QtWidgets.QApplication.activeModalWidget() is None
    facts["objects_after_bad_wall"] = len(document.Objects) - objects_before
    facts["undo_after_bad_wall"] = document.UndoCount

    child(window, "wall").setText("")
    child(window, "thickness").setProperty("rawValue", 3.0)
    later(task_panel_button("Ok").click)
    started = time.monotonic()
    yield lambda: not FreeCADGui.Control.activeDialog()
    facts["hollow_seconds"] = time.monotonic() - started
    container = document.getObject("Container")
    facts["undo_names"] = document.UndoNames
    facts["container"] = described(container)
    facts["mold_hidden"] = not mold.Visibility
    document.undo()
    facts["undone"] = document.getObject("Container") is None and mold.Visibility
    document.redo()
    container = document.getObject("Container")
    facts["redone"] = described(container)

    select(container)
    FreeCADGui.runCommand("Glass_SetGlass")
    yield lambda: task_panel_button("Ok")
    clear = container.ViewObject.ShapeColor[:3]
    child(window, "glass").choose("amber")
    yield settled()
    facts["transmission_shown"] = child(window, "transmission").isVisible()
    screenshot("glass_panel")
    facts["live_colour_differs"] = container.ViewObject.ShapeColor[:3] != clear
    later(task_panel_button("Cancel").click)
    yield lambda: not FreeCADGui.Control.activeDialog()
    facts["glass_after_cancel"] = container.Glass
    facts["colour_after_cancel"] = container.ViewObject.ShapeColor[:3] == clear

    from glassworkbench.gui.glass_panel import GlassPanel

    panel = GlassPanel(container)
    FreeCADGui.Control.showDialog(panel)
    yield lambda: task_panel_button("Ok")
    (FOLDER / "own.toml").write_text('[glass.heavy_blue]\nlike = "cobalt_blue"\ndensity_g_per_cm3 = 3.0\n')
    panel.add_glasses(str(FOLDER / "own.toml"))
    facts["glass_added"] = container.Glass
    later(lambda: panel.add_glasses(str(FOLDER / "own.toml")))
    yield lambda: QtWidgets.QApplication.activeModalWidget() is not None
    facts["dialog_of_added_twice"] = open_dialog()
    later(task_panel_button("Cancel").click)
    yield lambda: not FreeCADGui.Control.activeDialog()
    facts["glass_after_adding_and_cancel"] = container.Glass

    FreeCADGui.runCommand("Glass_SetGlass")
    yield lambda: task_panel_button("Ok")
    child(window, "glass").choose("emerald")
    later(task_panel_button("Ok").click)
    yield lambda: not FreeCADGui.Control.activeDialog()
    facts["glass"] = container.Glass
    facts["colour"] = container.ViewObject.ShapeColor[:3]
    facts["transparency"] = container.ViewObject.Transparency
    facts["undo_after_glass"] = document.UndoNames

    select(container)
    FreeCADGui.runCommand("Glass_ShowWall")
    facts["display_mode_of_wall"] = container.ViewObject.DisplayMode
    FreeCADGui.activeDocument().activeView().fitAll()
    FreeCADGui.Selection.clearSelection()
    yield settled()
    screenshot("wall_window")
    FreeCADGui.activeDocument().activeView().saveImage(str(FOLDER / "wall.png"), 600, 800, "White")
    select(container)
    FreeCADGui.runCommand("Glass_ShowWall")
    facts["display_mode_after_wall"] = container.ViewObject.DisplayMode
    FreeCADGui.activeDocument().activeView().saveImage(str(FOLDER / "no_wall.png"), 600, 800, "White")

    select(container)
    FreeCADGui.runCommand("Glass_Render")
    yield lambda: task_panel_button("Ok")
    child(window, "station").setCurrentText("studio")
    child(window, "width").setValue(240)
    child(window, "height").setValue(320)
    child(window, "tolerance").setValue(10.0)
    later(task_panel_button("Ok").click)
    yield lambda: image_view() is not None
    view = image_view()
    passes = []
    yield lambda: view.running()
    view._thread.improved.connect(lambda image: passes.append(image), QtCore.Qt.QueuedConnection)
    # FreeCAD stays usable: an object is made while the picture is traced.
    box = document.addObject("Part::Box", "MadeMeanwhile")
    document.recompute()
    facts["made_while_running"] = view.running() and box.Shape.isValid()
    ticks = Ticks()
    started = time.monotonic()
    yield lambda: not view.running()
    facts["render_seconds"] = time.monotonic() - started
    facts["longest_pause"] = ticks.stop()
    facts["passes"] = len(passes)
    facts["status"] = child(view, "status").text()
    document.removeObject(box.Name)
    FreeCADGui.Selection.clearSelection()
    facts["active_view_is_3d"] = hasattr(FreeCADGui.activeDocument().activeView(), "viewFront")
    window.findChild(QtWidgets.QMdiArea).tileSubWindows()
    yield settled()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    yield settled()
    facts["canvas"] = on_screen(view._canvas)
    facts["picture_size"] = list(view.image.pixels.shape[:2])
    screenshot("window")
    view.save(FOLDER / "saved.png")
    view.save(FOLDER / "saved.exr")

    facts["ray"] = yield from followed(view)
    facts["refined"] = yield from refined(view)

    document.openTransaction("Thicker")
    container.WallThickness = 4.0
    document.recompute()
    document.commitTransaction()
    facts["thicker"] = described(container)

    path = str(FOLDER / "bottle.FCStd")
    document.saveAs(path)
    FreeCAD.closeDocument(document.Name)
    yield lambda: image_view() is None
    document = FreeCAD.openDocument(path)
    document.UndoMode = 1
    container = document.getObject("Container")
    facts["reopened"] = described(container)
    facts["recomputed_after_reopen"] = document.recompute()
    container.WallThickness = 3.0
    document.recompute()
    facts["thinner_after_reopen"] = described(container)

    shape = container.Shape
    document.openTransaction("Too thick")
    container.WallThickness = 60.0
    document.recompute()
    document.commitTransaction()
    facts["too_thick"] = {"fault": container.Fault, "shape_kept": container.Shape.isPartner(shape)}
    document.undo()
    facts["undone_too_thick"] = {"fault": container.Fault, "wall": container.WallThickness.Value}

    render = document.getObject("Render")
    render.Width, render.Height, render.Tolerance = 1600, 2400, 0.0005
    select(render)
    later(lambda: FreeCADGui.runCommand("Glass_Render"))
    yield lambda: image_view() is not None and image_view().running()
    view = image_view()
    yield lambda: child(view, "progress").value() > 0 or not view.running()
    started = time.monotonic()
    child(view, "cancel").click()
    yield lambda: not view.running()
    facts["cancel_seconds"] = time.monotonic() - started
    facts["status_after_cancel"] = child(view, "status").text()
    # Closing the window of a running picture ends its thread.
    child(view, "again").click()
    yield lambda: view.running()
    thread = view._thread
    view.parentWidget().close()
    yield lambda: image_view() is None
    facts["thread_ended_with_window"] = thread.isFinished()


def followed(view):
    """Click at the bottle's shoulder, and tell what shows of the ray."""
    render = FreeCAD.ActiveDocument.getObject("Render")
    FreeCADGui.activeDocument().activeView().viewAxonometric()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    yield settled()
    FreeCADGui.activeDocument().activeView().saveImage(str(FOLDER / "no_ray.png"), 600, 800, "White")
    place = view._canvas.place()
    click(view._canvas, place.x() + place.width() * 0.44, place.y() + place.height() * 0.6)
    yield settled()
    screenshot("ray_window")
    FreeCADGui.activeDocument().activeView().saveImage(str(FOLDER / "ray.png"), 600, 800, "White")
    return {"status": child(view, "status").text(), "mode": render.ViewObject.DisplayMode}


def refined(view):
    """Drag over a part of the picture, and tell how its error and that of the rest changed."""
    before = view.image
    height, width = before.pixels.shape[:2]
    place = view._canvas.place()
    corner = QtCore.QPoint(place.x() + place.width() * 3 // 8, place.y() + place.height() // 2)
    click(view._canvas, corner.x(), corner.y(), corner.x() + place.width() // 4, corner.y() + place.height() // 8)
    started = view.running()
    yield lambda: not view.running()
    part = view.image.report["parts"][0]["crop"]
    inside = np.zeros((height, width), dtype=bool)
    inside[part[1] : part[1] + part[3], part[0] : part[0] + part[2]] = True
    errors = [float(image.certificate[inside].max()) for image in (before, view.image)]
    same = bool(np.array_equal(before.pixels[~inside], view.image.pixels[~inside]))
    return {"started": started, "part": part, "errors": errors, "rest_is_same": same}


def click(widget, x, y, to_x=None, to_y=None):
    """Press and release the left button; where a second place is given, drag to there."""
    start = QtCore.QPoint(int(x), int(y))
    end = start if to_x is None else QtCore.QPoint(int(to_x), int(to_y))
    left, none = QtCore.Qt.LeftButton, QtCore.Qt.NoButton
    for kind, point, button, buttons in (
        (QtCore.QEvent.MouseButtonPress, start, left, left),
        (QtCore.QEvent.MouseMove, end, none, left),
        (QtCore.QEvent.MouseButtonRelease, end, left, none),
    ):
        event = QtGui.QMouseEvent(
            kind,
            QtCore.QPointF(point),
            QtCore.QPointF(widget.mapToGlobal(point)),
            button,
            buttons,
            QtCore.Qt.NoModifier,
        )
        QtWidgets.QApplication.sendEvent(widget, event)


def described(container):
    return {
        "valid": container.Shape.isValid(),
        "wall": container.WallThickness.Value,
        "glass": container.Glass,
        "fault": container.Fault,
        "weight_grams": container.WeightGrams,
        "capacity_ml": container.BrimfulCapacity.Value / 1000.0,
        "minimum_wall": container.MinimumWall.Value,
        "volume": mesh_volume(container.Shape),
        "method": container.MethodUsed,
    }


def mesh_volume(shape):
    """Return mm3; Shape.Volume is wrong by some percent on long B-spline faces."""
    points, triangles = shape.tessellate(0.05)
    a, b, c = np.array([tuple(point) for point in points])[np.array(triangles)].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def select(obj):
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(obj)


def image_view():
    from glassworkbench.gui.image_view import ImageView

    views = FreeCADGui.getMainWindow().findChildren(ImageView)
    return views[0] if views else None


def settled():
    """Return a condition that holds once the window had time to paint: three rounds of the event loop."""
    rounds = iter(range(10))
    return lambda: next(rounds, None) is None


class Ticks:
    """Measures the longest pause of the event loop."""

    def __init__(self):
        self._last = time.monotonic()
        self._longest = 0.0
        self._timer = QtCore.QTimer()
        self._timer.timeout.connect(self._tick)
        self._timer.start(5)

    def _tick(self):
        now = time.monotonic()
        self._longest = max(self._longest, now - self._last)
        self._last = now

    def stop(self):
        self._timer.stop()
        return self._longest


runner = Runner(main_job)
