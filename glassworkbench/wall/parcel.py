"""Packs what goes to a worker process and back: any picklable data, and OCC shapes in it as BREP."""

from __future__ import annotations

import io
import pickle

from glassworkbench.freecad import Part


def pack(content: object) -> bytes:
    """Return data, with the shapes in it, as bytes."""
    buffer = io.BytesIO()
    _Pickler(buffer, protocol=pickle.HIGHEST_PROTOCOL).dump(content)
    return buffer.getvalue()


def unpack(parcel: bytes) -> object:
    """Return what was packed; only for bytes that this program has written itself."""
    return pickle.loads(parcel)


class _Pickler(pickle.Pickler):
    def reducer_override(self, item: object) -> object:
        # FreeCAD's own pickling of shapes goes through temporary files, and fails for empty ones.
        if not isinstance(item, Part.Shape):
            return NotImplemented
        return _shape, (item.exportBrepToString() if not item.isNull() else "",)


def _shape(brep: str) -> Part.Shape:
    shape = Part.Shape()
    if brep:
        shape.importBrepFromString(brep)
    return shape.Solids[0] if brep and shape.ShapeType == "Solid" else shape
