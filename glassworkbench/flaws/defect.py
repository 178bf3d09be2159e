"""What every defect has: a place, and a class; and what it puts into the glass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from glassworkbench.scene import Revolved
from glassworkbench.scene.validate import finite, positive
from glassworkbench.settings import unknown_name

CLASSES = ("critical", "major", "minor")
"""May hurt who uses the container; may make it useless; spoils its looks."""


@dataclass(frozen=True)
class Substance:
    """What a defect is made of.

    Parameters
    ----------
    name : str
        Begins the name of its body in the scene.
    refractive_index : float or None
        None where it is the glass's own, plus `index_offset`.
    index_offset : float
    absorption_per_mm : float or None
        Napierian, the same for all colours; None where it is the glass's own.
    """

    name: str
    refractive_index: float | None = None
    index_offset: float = 0.0
    absorption_per_mm: float | None = None


AIR = Substance("air", 1.0, absorption_per_mm=0.0)


@dataclass(frozen=True, eq=False)
class Grain:
    """An ellipsoid of a substance.

    Parameters
    ----------
    centre_mm, semi_axes_mm : array (3,)
    rotation : array (3, 3)
        Columns are the directions of the semi-axes.
    substance : Substance
    within_wall : bool
        Whether all of it must lie in the glass; else its centre alone, and what reaches out is open.
    """

    centre_mm: np.ndarray
    semi_axes_mm: np.ndarray
    rotation: np.ndarray
    substance: Substance
    within_wall: bool = True


@dataclass(frozen=True, eq=False)
class Thread:
    """A turned piece of the container's own glass that stands in the cavity.

    Parameters
    ----------
    surface : Revolved
    roots_mm : array (n, 3)
        Centres of the ends that lie in the wall.
    root_radius_mm : float
    """

    surface: Revolved
    roots_mm: np.ndarray
    root_radius_mm: float


@dataclass(frozen=True, eq=False)
class Site:
    """The place in the wall where a defect lies, and the directions there.

    Parameters
    ----------
    outside_mm : array (3,)
        On the outer surface, at the defect's height and angle.
    frame : array (3, 3)
        Columns are horizontal along the surface, up along it, and outward, orthonormal.
    wall_mm : float
        Thickness straight inward from there.
    """

    outside_mm: np.ndarray
    frame: np.ndarray
    wall_mm: float

    def at_depth_mm(self, depth_mm: float | None) -> np.ndarray:
        """Return the point (3,) so far under the outer surface; in the middle of the wall for None."""
        return self.outside_mm - (0.5 * self.wall_mm if depth_mm is None else depth_mm) * self.frame[:, 2]


@dataclass(frozen=True, kw_only=True)
class Defect:
    """A defect of a container.

    Parameters
    ----------
    angle_deg : float
        About the axis, counter-clockwise seen from above, from the upright container's +x.
    severity : str
        One of `CLASSES`; the kind's usual one where not given.
    """

    kind: ClassVar[str]
    """The industry's name."""

    description: ClassVar[str]

    usual_severity: ClassVar[str] = "minor"

    angle_deg: float
    severity: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "angle_deg", self._finite("angle_deg"))
        severity = self.severity or self.usual_severity
        if severity not in CLASSES:
            raise unknown_name(f"{self.kind}: class", severity, CLASSES)
        object.__setattr__(self, "severity", severity)

    def __str__(self) -> str:
        return f"{self.kind} at {self.angle_deg:.4g} deg"

    def _finite(self, field: str) -> float:
        return finite(getattr(self, field), f"{self.kind}: {field}")

    def _check_positive(self, *fields: str) -> None:
        for field in fields:
            object.__setattr__(self, field, positive(getattr(self, field), f"{self.kind}: {field}"))


@dataclass(frozen=True, kw_only=True)
class OnSide(Defect):
    """A defect at a height.

    Parameters
    ----------
    height_mm : float
        Above the container's lowest point.
    """

    height_mm: float

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "height_mm", self._finite("height_mm"))

    def __str__(self) -> str:
        return f"{self.kind} at {self.height_mm:.4g} mm, {self.angle_deg:.4g} deg"


@dataclass(frozen=True, kw_only=True)
class InWall(OnSide):
    """A defect in the glass itself.

    Parameters
    ----------
    depth_mm : float, optional
        Of its middle under the outer surface; in the middle of the wall where not given.
    """

    depth_mm: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.depth_mm is not None:
            self._check_positive("depth_mm")

    def grains(self, site: Site) -> tuple[Grain, ...]:
        """Return the ellipsoids that it is; where they overlap, the first holds."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class InCavity(OnSide):
    """A defect of glass inside the container."""

    def thread(self, site: Site, other: Site) -> Thread:
        """Return the glass between two places of the wall; `other` lies at `other_angle_deg`."""
        raise NotImplementedError

    @property
    def other_angle_deg(self) -> float:
        """The angle of the place in the wall that lies across."""
        return self.angle_deg + 180.0


@dataclass(frozen=True, kw_only=True)
class InThickness(OnSide):
    """A defect of the wall's thickness: it is made when the container is hollowed."""

    def added_mm(self, height_mm: np.ndarray, angle_deg: np.ndarray, radius_mm: float) -> np.ndarray:
        """Return how much thicker the wall is for it, at heights and angles of a container of this radius."""
        raise NotImplementedError

    def rows_mm(self) -> np.ndarray:
        """Return heights (n,) at which the thickness must be told for it."""
        raise NotImplementedError

    def columns_deg(self, radius_mm: float) -> np.ndarray:
        """Return angles (n,) at which it must be told; none where it goes all around."""
        return np.zeros(0)


@dataclass(frozen=True, kw_only=True)
class InShape(Defect):
    """A defect of the whole shape, inside and out: the mold is deformed before it is hollowed."""

    def deformation(self, radius_mm: float) -> np.ndarray:
        """Return the matrix (3, 3) that points of the upright container of this radius are multiplied with."""
        raise NotImplementedError


def turned_in_surface(site: Site, direction_deg: float) -> np.ndarray:
    """Return the site's frame (3, 3) turned in the surface, so that its first column is along `direction_deg`.

    0 is horizontal, 90 straight up.
    """
    angle = np.radians(direction_deg)
    across, up, outward = site.frame.T
    along = np.cos(angle) * across + np.sin(angle) * up
    return np.column_stack([along, np.cross(outward, along), outward])
