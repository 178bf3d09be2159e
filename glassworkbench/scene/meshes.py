"""Triangle meshes from PLY, OBJ and STL files."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.scene.mesh import Mesh

CREASE_RAD = np.radians(30.0)
"""Faces that meet at a larger angle keep an edge between them when a file has no normals."""


def read_mesh(path: str | Path) -> Mesh:
    """Return the mesh of a PLY, OBJ or STL file, in the file's coordinates (mm).

    Polygons are cut into triangles. Without normals in the file, those of neighbouring faces are averaged
    unless the faces meet at more than `CREASE_RAD`.

    Raises
    ------
    InputError
        If the file is missing, of another kind, damaged, or its mesh not closed.
    """
    vertices, triangles, normals = read_triangles(path)
    try:
        if normals is None:
            return Mesh(*with_creased_normals(vertices, triangles), has_averaged_normals=True)
        return Mesh(vertices, triangles, normals)
    except (InputError, ValueError) as error:
        raise InputError(f"{path}: {error}") from error


def read_triangles(path: str | Path) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Return vertices (n, 3), triangles (m, 3) and normals (n, 3) of a PLY, OBJ or STL file, closed or not.

    The normals are None where the file has none.

    Raises
    ------
    InputError
        If the file is missing, of another kind, or damaged.
    """
    path = Path(path)
    readers = {".ply": _read_ply, ".obj": _read_obj, ".stl": _read_stl}
    if path.suffix.lower() not in readers:
        raise InputError(f"{path}: a mesh must end in {', '.join(readers)}")
    if not path.is_file():
        raise InputError(f"{path}: there is no such file; check the path")
    data = path.read_bytes()
    if not data.strip():
        raise InputError(f"{path}: the file is empty; export it again")
    try:
        return readers[path.suffix.lower()](data)
    except (ValueError, IndexError, KeyError, struct.error) as error:
        raise InputError(f"{path}: not a mesh that can be read ({error})") from error


def _read_stl(data: bytes) -> tuple[np.ndarray, np.ndarray, None]:
    count = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + 50 * count:
        facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        corners = np.frombuffer(data, facet, count, 84)["corners"].reshape(-1, 3)
    else:
        words = data.split()
        places = [place for place, word in enumerate(words) if word == b"vertex"]
        corners = np.array([[float(number) for number in words[place + 1 : place + 4]] for place in places])
        if len(corners) == 0 or len(corners) % 3:
            raise ValueError("neither a binary nor a text STL")
    vertices, place = np.unique(corners.astype(np.float64), axis=0, return_inverse=True)
    return vertices, place.reshape(-1, 3), None


def _read_obj(data: bytes) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    vertices, normals, sides, corners = [], [], [], []
    for line in data.decode("utf-8", errors="replace").splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            vertices.append([float(word) for word in words[:3]])
        elif kind == "vn":
            normals.append([float(word) for word in words[:3]])
        elif kind == "f":
            sides.append(len(words))
            for word in words:
                vertex, _, rest = word.partition("/")
                normal = rest.partition("/")[2]
                corners.append((_place(vertex, vertices), _place(normal, normals) if normal else -1))
    corners = np.array(corners).reshape(-1, 2)
    if not normals or np.any(corners[:, 1] < 0):
        return np.array(vertices), _fans(sides, corners[:, 0]), None
    pairs, place = np.unique(corners, axis=0, return_inverse=True)
    return np.array(vertices)[pairs[:, 0]], _fans(sides, place.reshape(-1)), _unit(np.array(normals)[pairs[:, 1]])


def _place(number: str, rows: list) -> int:
    """Return the place that an OBJ number means: counted from 1, or back from the latest row if negative."""
    place = int(number) - 1 if int(number) > 0 else int(number) + len(rows)
    if not 0 <= place < len(rows):
        raise ValueError(f"number {number} is out of range")
    return place


_PLY_TYPES = {
    "char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H",
    "int": "i", "int32": "i", "uint": "I", "uint32": "I", "float": "f", "float32": "f", "double": "d", "float64": "d",
}  # fmt: skip


class _Words:
    """Takes numbers from the text that follows a PLY header."""

    def __init__(self, body: bytes) -> None:
        self._words, self._place = body.split(), 0

    def take(self, types: str) -> tuple[float, ...]:
        words = self._words[self._place : self._place + len(types)]
        if len(words) < len(types):
            raise ValueError("the file ends early")
        self._place += len(types)
        return tuple(float(word) for word in words)


class _Bytes:
    """Takes numbers from the bytes that follow a PLY header."""

    def __init__(self, body: bytes, order: str) -> None:
        self._body, self._order, self._offset = body, order, 0

    def take(self, types: str) -> tuple[float, ...]:
        packed = struct.Struct(self._order + types)
        self._offset += packed.size
        return packed.unpack_from(self._body, self._offset - packed.size)


def _read_ply(data: bytes) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    end = data.index(b"end_header")
    header = [line.split() for line in data[:end].decode("ascii", errors="replace").splitlines()]
    form = next((words[1] for words in header if words[:1] == ["format"]), "")
    body = data[data.index(b"\n", end) + 1 :]
    numbers = _Words(body) if form == "ascii" else _Bytes(body, "<" if form == "binary_little_endian" else ">")
    columns, polygons = {}, []
    for name, count, properties in _ply_elements(header):
        if name == "face":
            polygons = [_ply_polygon(numbers, properties) for _ in range(count)]
        else:
            types = "".join(_PLY_TYPES[words[1]] for words in properties)
            table = np.array(numbers.take(types * count), dtype=np.float64).reshape(count, len(types))
            if name == "vertex":
                columns = {words[-1]: table[:, k] for k, words in enumerate(properties)}
    vertices = np.column_stack([columns[key] for key in "xyz"])
    triangles = _fans(
        [len(polygon) for polygon in polygons], np.array([v for p in polygons for v in p], dtype=np.int64)
    )
    if "nx" not in columns:
        return vertices, triangles, None
    return vertices, triangles, _unit(np.column_stack([columns[key] for key in ("nx", "ny", "nz")]))


def _ply_elements(header: list[list[str]]) -> list[tuple[str, int, list[list[str]]]]:
    """Return name, count and the words of each property line of each element."""
    elements = []
    for words in header:
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words)
    return elements


def _ply_polygon(numbers: _Words | _Bytes, properties: list[list[str]]) -> tuple[float, ...]:
    """Return the vertex numbers of the next face, passing over its other properties."""
    polygon = ()
    for words in properties:
        if words[1] != "list":
            numbers.take(_PLY_TYPES[words[1]])
            continue
        length = int(numbers.take(_PLY_TYPES[words[2]])[0])
        values = numbers.take(_PLY_TYPES[words[3]] * length)
        if words[4] in ("vertex_indices", "vertex_index"):
            polygon = values
    return polygon


def _fans(sides: list[int], corners: np.ndarray) -> np.ndarray:
    """Return triangles (n, 3) from polygons that have `sides` corners each, one after the other in `corners`."""
    sides = np.array(sides, dtype=np.int64)
    if len(sides) == 0 or sides.min() < 3:
        raise ValueError("it has no faces, or one with fewer than three corners")
    first = np.repeat(np.cumsum(sides) - sides, sides - 2)
    step = np.arange(len(first)) - np.repeat(np.cumsum(sides - 2) - (sides - 2), sides - 2)
    return corners[np.column_stack([first, first + step + 1, first + step + 2])].astype(np.int64)


def with_creased_normals(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices, triangles and normals with a vertex stored once for each smooth piece around it.

    Faces that meet at more than `CREASE_RAD` keep an edge between them.
    """
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise ValueError("a vertex number is out of range")
    vertices, place = np.unique(vertices, axis=0, return_inverse=True)
    triangles = place.reshape(-1)[triangles]
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area_normals = np.cross(b - a, c - a)
    solid = np.any(area_normals != 0.0, axis=1)
    triangles, area_normals = triangles[solid], area_normals[solid]
    face_normals = _unit(area_normals)
    angles = _corner_angles(vertices[triangles]).reshape(-1)

    # Every corner looks at every corner of the same vertex: sorted by vertex they are runs of equal length.
    vertex_of = triangles.reshape(-1)
    order = np.argsort(vertex_of, kind="stable")
    counts = np.bincount(vertex_of, minlength=len(vertices))
    start = np.cumsum(counts) - counts
    fan = counts[vertex_of]
    corner = np.repeat(np.arange(len(vertex_of)), fan)
    within = np.arange(len(corner)) - np.repeat(np.cumsum(fan) - fan, fan)
    other = order[start[vertex_of[corner]] + within]
    cosines = np.einsum("ij,ij->i", face_normals[corner // 3], face_normals[other // 3])
    corner, other = corner[cosines >= np.cos(CREASE_RAD)], other[cosines >= np.cos(CREASE_RAD)]
    sums = np.zeros((len(vertex_of), 3))
    np.add.at(sums, corner, angles[other, None] * face_normals[other // 3])

    # Rounded, so that sums of the same triangles in another order count as the same normal.
    rows = np.column_stack([vertex_of, np.round(_unit(sums), 9)])
    rows, place = np.unique(rows, axis=0, return_inverse=True)
    return vertices[rows[:, 0].astype(np.int64)], place.reshape(-1, 3), _unit(rows[:, 1:])


def _corner_angles(corners: np.ndarray) -> np.ndarray:
    """Return the angle (rad) at each corner of triangles (n, 3, 3), (n, 3).

    Normals weighted by it do not depend on how a surface is cut into triangles (Thuermer and Wuethrich 1998).
    """
    ahead = np.roll(corners, -1, axis=1) - corners
    behind = np.roll(corners, 1, axis=1) - corners
    across = np.linalg.norm(np.cross(ahead, behind), axis=2)
    return np.arctan2(across, np.einsum("ijk,ijk->ij", ahead, behind))


def _unit(vectors: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)
