"""The hollow container: its solid, what the tracer sees of it, and the report on its wall."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from glassworkbench.errors import GlassWorkbenchError
from glassworkbench.freecad import Part
from glassworkbench.mold import Mold, outer_meridian
from glassworkbench.mold.mold import moved
from glassworkbench.mold.tessellation import outside_mesh, tessellate
from glassworkbench.output import check_writable, written_aside
from glassworkbench.scene import ContainerGeometry, Mesh, Revolved, Surface
from glassworkbench.wall.asking.shortened import shortened
from glassworkbench.wall.asking.thickness import Thickness
from glassworkbench.wall.glass_mesh import glass_mesh, write_stl
from glassworkbench.wall.measuring.contents import LIQUID_G_PER_CM3, Cavity, FillPoint, centre_of_gravity
from glassworkbench.wall.measuring.map_picture import save_picture
from glassworkbench.wall.measuring.measure import WallMeasure
from glassworkbench.wall.measuring.outside import Outside, is_mouth, outside_as_meshed
from glassworkbench.wall.measuring.volumes import Volume
from glassworkbench.wall.measuring.wall_map import WallMap, wall_map
from glassworkbench.wall.seen import seen_surface
from glassworkbench.wall.solid_file import write_solid
from glassworkbench.wall.worker import run_in_worker

ENDINGS = (".step", ".stp", ".brep", ".fcstd", ".stl")

STL_DEVIATION_MM = 0.02
"""How far the triangles of an STL file may be off the solid."""

STL_SECONDS = 120.0
"""How long OCC may take over the triangles."""


@dataclass(frozen=True)
class Attempt:
    """How one method fared.

    Parameters
    ----------
    method : str
    outcome : {"accepted", "rejected", "impossible", "failed"}
        Rejected is what was measured, but not good enough; impossible, that there is no such wall.
    why : str
    seconds : float
    details : tuple of str
        Where a method has several ways, how each fared that it tried.
    """

    method: str
    outcome: str
    why: str
    seconds: float
    details: tuple[str, ...] = ()

    def to_json(self) -> dict[str, object]:
        """Return the attempt as it stands in a report."""
        return {
            "method": self.method,
            "outcome": self.outcome,
            "why": self.why,
            "seconds": round(self.seconds, 3),
            "details": list(self.details),
        }


@dataclass(frozen=True)
class SolidFacts:
    """What OCC and the methods' own checks say of the solid.

    `facets_off_mm` is how far flat facets of its inside may be off the smooth inside that is measured.
    """

    valid: bool
    closed: bool
    self_intersecting: bool
    faces: int
    facets_off_mm: float = 0.0


@dataclass(frozen=True, eq=False)
class WallReport:
    """What was asked, what was tried, and what came out; positions are in CAD coordinates.

    Parameters
    ----------
    method : str
    tried : tuple of Attempt
    asked : str
        The wall as `parse_thickness` reads it.
    wall : WallMeasure
        `minimum_at_mm` in CAD coordinates.
    tolerance_mm : float
        What 99 % of the deviations had to stay within.
    solid : SolidFacts
    glass_volume_mm3, weight_g, brimful_ml : float
        The weight is that of soda-lime glass, 2.5 g/cm3.
    centre_of_gravity_mm : array (3,)
        Of the glass.
    centre_of_gravity_filled_mm : array (3,)
        Of the glass and the water that fills it brimful.
    area_outside_mm2, area_inside_mm2 : float
        Of the glass outside and inside, as far as the finish plane; what lies in that is neither.
    seconds : float
    notes : tuple of str
        What the user should know besides, in sentences.
    """

    method: str
    tried: tuple[Attempt, ...]
    asked: str
    wall: WallMeasure
    tolerance_mm: float
    solid: SolidFacts
    glass_volume_mm3: float
    weight_g: float
    brimful_ml: float
    centre_of_gravity_mm: np.ndarray
    centre_of_gravity_filled_mm: np.ndarray
    area_outside_mm2: float
    area_inside_mm2: float
    seconds: float
    notes: tuple[str, ...] = ()

    def to_json(self) -> dict[str, object]:
        """Return the report as plain dictionaries, lists, strings and numbers."""
        return {
            "method": self.method,
            "tried": [attempt.to_json() for attempt in self.tried],
            "wall": {
                "asked": self.asked,
                "samples": self.wall.samples,
                "min_mm": self.wall.minimum_mm,
                "min_at_mm": [float(coordinate) for coordinate in self.wall.minimum_at_mm],
                "deviation_max_mm": self.wall.deviation_max_mm,
                "deviation_p99_mm": self.wall.deviation_p99_mm,
                "deviation_rms_mm": self.wall.deviation_rms_mm,
                "thinner_than_asked_max": self.wall.thinner_than_asked_max,
                "tolerance_mm": self.tolerance_mm,
            },
            "solid": {
                "valid": self.solid.valid,
                "closed": self.solid.closed,
                "self_intersecting": self.solid.self_intersecting,
                "faces": self.solid.faces,
                "facets_off_mm": self.solid.facets_off_mm,
            },
            "glass_volume_mm3": self.glass_volume_mm3,
            "weight_g": self.weight_g,
            "brimful_ml": self.brimful_ml,
            "centre_of_gravity_mm": [float(coordinate) for coordinate in self.centre_of_gravity_mm],
            "centre_of_gravity_filled_mm": [float(coordinate) for coordinate in self.centre_of_gravity_filled_mm],
            "surface_area_mm2": {"outside": self.area_outside_mm2, "inside": self.area_inside_mm2},
            "seconds": round(self.seconds, 3),
            "notes": list(self.notes),
        }


@dataclass(frozen=True, eq=False)
class Container:
    """A hollow container.

    Parameters
    ----------
    mold : Mold
    thickness : Thickness
    method : str
        The method that made the cavity.
    solid : Part.Shape or None
        The glass, one closed solid in CAD coordinates; None where there are only meshes.
    cavity : Surface or Part.Shape
        What is taken away from the outside, upright, reaching past the mouth.
    inside : Mesh
        The cavity, upright, closed level at the finish plane.
    outer : Mesh
    outer_faces : int array (m,)
        The mold's outside as it was measured from, and its triangles' faces, as `outside_mesh` gives them.
    report : WallReport
    """

    mold: Mold
    thickness: Thickness
    method: str
    solid: Part.Shape | None
    cavity: Surface | Part.Shape
    inside: Mesh
    outer: Mesh
    outer_faces: np.ndarray
    report: WallReport

    @cached_property
    def wall(self) -> Outside:
        """The mold's outside, with the thickness asked on it."""
        return outside_as_meshed(self.mold, self.outer, self.outer_faces, self.thickness.on(self.mold).at)

    def geometry(self) -> ContainerGeometry:
        """Return the container as a station takes it: upright, on surfaces that the tracer knows."""
        return geometry_within(self.mold, self.cavity)

    @property
    def room(self) -> Cavity:
        """The room inside: its capacity at any level, and the level of any capacity."""
        return Cavity(self.inside)

    def filled(self, level_mm: float, liquid_g_per_cm3: float = LIQUID_G_PER_CM3) -> FillPoint:
        """Return capacity and centre of gravity (CAD coordinates) of the container filled up to a height.

        Raises
        ------
        InputError
            If the level, above the container's lowest point, is not inside it.
        """
        liquid = self.room.filled(level_mm)
        place = self.mold.placement
        there = Volume(liquid.volume_mm3, place[:3, :3] @ liquid.centroid_mm + place[:3, 3])
        glass = Volume(self.report.glass_volume_mm3, self.report.centre_of_gravity_mm)
        balance = centre_of_gravity(glass, there, liquid_g_per_cm3=liquid_g_per_cm3)
        return FillPoint(float(level_mm), 1e-3 * liquid.volume_mm3, balance)

    def map(self) -> WallMap:
        """Return the thickness of the wall all over the outside, and over height."""
        return wall_map(self.mold, self.inside, self.wall)

    def save_map(self, path: str | Path) -> None:
        """Draw the map of the wall into a PNG, SVG or PDF file.

        Raises
        ------
        InputError
            If its ending is unknown, its folder cannot be written to, or matplotlib is missing.
        """
        save_picture(self.map(), f"{self.mold.name}: wall {shortened(self.thickness)} by {self.method}", path)

    def save(self, path: str | Path) -> None:
        """Write the solid as STEP, BREP, FCStd or STL (triangles within `STL_DEVIATION_MM`), by the path's ending.

        Raises
        ------
        InputError
            If the ending is unknown or the folder cannot be written to.
        GlassWorkbenchError
            If writing fails, a CAD file does not hold the same solid when it is read again, or there are only meshes
            and the ending is not that of a mesh.
        """
        path = check_writable(path, ENDINGS)
        if self.solid is None and path.suffix.lower() != ".stl":
            raise GlassWorkbenchError(f"{path}: the container is a mesh, which can be written as STL only; name it so")
        with written_aside(path) as aside:
            try:
                if path.suffix.lower() == ".stl":
                    # OCC's own writer chooses its triangles itself, millions of them, and writes them as text.
                    write_stl(self._glass_mesh(), self.mold.placement, aside)
                else:
                    write_solid(self.solid, self.mold.name, aside)
            except Exception as error:
                raise GlassWorkbenchError(f"{path}: could not be written ({error})") from error

    def _glass_mesh(self) -> Mesh:
        """Return the glass as a closed mesh, upright."""
        if self.solid is None or isinstance(self.cavity, Mesh):
            outer, faces = outside_mesh(self.mold, STL_DEVIATION_MM)
            try:
                return glass_mesh(outer, is_mouth(self.mold, faces), self.inside)
            except GlassWorkbenchError:
                if self.solid is None:
                    raise
        upright = moved(self.solid, np.linalg.inv(self.mold.placement))
        # OCC can take minutes over one smooth face, and nothing but the end of its process stops it.
        return run_in_worker(tessellate, (upright, STL_DEVIATION_MM), {}, STL_SECONDS)


def geometry_within(mold: Mold, cavity: Surface | Part.Shape) -> ContainerGeometry:
    """Return a container by its outer shape and its cavity (upright), as a station takes it."""
    anatomy = mold.anatomy
    notes: tuple[str, ...] = ()
    if mold.mesh is not None:
        outer = mold.mesh
    elif anatomy.is_revolved:
        outer = Revolved(outer_meridian(mold))
    else:
        outer, notes = seen_surface(mold.upright, "the outside")
    if isinstance(cavity, Part.Shape):
        cavity, more = seen_surface(cavity, "the cavity")
        notes += more
    if isinstance(outer, Revolved):
        radius = anatomy.maximum_radius_mm
        low, high = np.array([-radius, -radius, 0.0]), np.array([radius, radius, anatomy.height_mm])
    else:
        low, high = outer.box_mm
    return ContainerGeometry(outer, cavity, low, high, anatomy.finish_height_mm, notes)
