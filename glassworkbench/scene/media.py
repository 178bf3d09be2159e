"""Media, and the one table that says which medium holds inside which bodies."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field

import numpy as np

from glassworkbench.errors import InputError
from glassworkbench.glass import Filling, Glass
from glassworkbench.scene.validate import finite, finite_array

MAXIMUM_BODIES = 16
"""A ray carries one bit a body, and the table has a row for each combination of bits."""


@dataclass(frozen=True, eq=False)
class Medium:
    """A homogeneous, isotropic medium and where it holds.

    Parameters
    ----------
    where : str
        Boolean expression over body names, like ``outer and not cavity``.
    refractive_index : float
        At least 1.
    absorption_per_mm : array (3,)
        Napierian absorption coefficient (1/mm) for R, G, B; transmission over x mm is exp(-absorption x).
    """

    where: str
    refractive_index: float
    absorption_per_mm: np.ndarray = field(default=(0.0, 0.0, 0.0))

    def __post_init__(self) -> None:
        index = finite(self.refractive_index, "refractive_index")
        if index < 1.0:
            raise InputError(f"refractive_index: must be at least 1, got {index:g}")
        object.__setattr__(self, "refractive_index", index)
        absorption = finite_array(self.absorption_per_mm, (3,), "absorption_per_mm")
        if np.any(absorption < 0.0):
            raise InputError("absorption_per_mm: must not be negative")
        object.__setattr__(self, "absorption_per_mm", absorption)
        _parse(self.where)

    @classmethod
    def of(cls, where: str, material: Glass | Filling) -> Medium:
        """Return the medium of a material of the catalogue, for light that is traced as R, G and B."""
        return cls(where, material.refractive_index_d, material.rgb_absorption_per_mm())


def medium_table(body_names: tuple[str, ...], media: tuple[Medium, ...]) -> np.ndarray:
    """Return which medium holds for each combination of bodies.

    Parameters
    ----------
    body_names : tuple of str
        Body k sets bit ``1 << k``.
    media : tuple of Medium
        The first whose expression is true holds.

    Returns
    -------
    int32 array (2 ** len(body_names),)
        0 for the surroundings, k + 1 for ``media[k]``.

    Raises
    ------
    InputError
        If an expression names an unknown body, or there are more bodies than bits.
    """
    if len(body_names) > MAXIMUM_BODIES:
        raise InputError(f"body: {len(body_names)} bodies, but a scene may have at most {MAXIMUM_BODIES}")
    rows = np.arange(1 << len(body_names))
    inside = {name: (rows >> bit) & 1 == 1 for bit, name in enumerate(body_names)}
    table = np.zeros(len(rows), dtype=np.int32)
    for number, medium in reversed(list(enumerate(media, start=1))):
        table[_evaluate(_parse(medium.where), inside, medium.where)] = number
    if table[0] != 0:
        raise InputError(f"medium where {media[table[0] - 1].where!r}: it holds outside all bodies, where air must be")
    return table


def _parse(where: str) -> ast.expr:
    try:
        return ast.parse(where.strip(), mode="eval").body
    except (SyntaxError, ValueError, AttributeError) as error:
        raise InputError(f"medium where {where!r}: expected body names joined by and, or, not") from error


def _evaluate(node: ast.expr, inside: dict[str, np.ndarray], where: str) -> np.ndarray:
    if isinstance(node, ast.Name):
        if node.id not in inside:
            raise InputError(f"medium where {where!r}: no body is named {node.id!r}; there is {', '.join(inside)}")
        return inside[node.id]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return ~_evaluate(node.operand, inside, where)
    if isinstance(node, ast.BoolOp):
        combine = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
        return combine.reduce([_evaluate(value, inside, where) for value in node.values])
    raise InputError(f"medium where {where!r}: expected body names joined by and, or, not")
