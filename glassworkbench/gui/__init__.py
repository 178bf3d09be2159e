"""The workbench in FreeCAD's window: commands, task panels, and the view of an image."""
