"""How the mass of a block is spread: its centre, its inertia, parts of another density."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

from geometry.density import LinearDensity, Part, Tensor, tensor_of
from solver.errors import SceneError, Statement
from solver.scene.checking import Checked, shown
from solver.scene.quantities import Density, Position

ROUND_OFF = 1e-9
"""Part of a size by which parts may overlap, and of a moment by which a table may be uneven."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PartSpec(Checked):
    """A part of a block: an entry of `parts`."""

    start: Position = field(metadata={"key": "from"})
    """Its lowest corner, from the middle of the block's bottom, m."""
    end: Position = field(metadata={"key": "to"})
    """Its highest corner, m."""
    density: Density
    """rho there, kg/m³."""

    def check(self) -> None:
        """Refuse what is no box."""
        if len(self.start) != len(self.end):
            raise SceneError("to", shown(self.end), f"{len(self.start)} values, as many as in from")
        if not all(low < high for low, high in zip(self.start, self.end, strict=True)):
            raise SceneError("to", shown(self.end), f"more than from = {shown(self.start)} in each")

    @property
    def part(self) -> Part:
        """The same as a box."""
        return Part(self.start, self.end, self.density)


def refuse_parts(parts: Sequence[PartSpec], sizes: Sequence[float]) -> None:
    """Refuse parts outside of a block of these edges (m), and those that overlap."""
    low = [*(-size / 2 for size in sizes[:-1]), 0.0]
    high = [*(size / 2 for size in sizes[:-1]), sizes[-1]]
    tiny = ROUND_OFF * max(sizes)
    for number, part in enumerate(parts, 1):
        ends = zip(low, part.start, part.end, high, strict=True)
        if not all(a - tiny <= b and c <= d + tiny for a, b, c, d in ends):
            said = f"reaches outside the block, which is from {shown(low)} to {shown(high)}"
            raise Statement(f"parts: number {number}", said)
    for (one, first), (other, second) in combinations(enumerate(parts, 1), 2):
        common = zip(first.start, first.end, second.start, second.end, strict=True)
        if all(min(b, d) - max(a, c) > tiny for a, b, c, d in common):
            raise Statement(f"parts: numbers {one} and {other}", "overlap")


def refuse_centre(centre: Sequence[float], low: Sequence[float], high: Sequence[float]) -> None:
    """Refuse a centre of mass that is not inside the box around a block, by its corners, m."""
    if not all(a < c < b for a, c, b in zip(low, centre, high, strict=True)):
        axes = ("x", "y", "z")[: len(centre)]
        ends = [f"{a:g} < {axis} < {b:g}" for axis, a, b in zip(axes, low, high, strict=True)]
        raise SceneError("centre_of_mass", shown(centre), f"a place inside, {', '.join(ends)}")


def refuse_uneven(density: LinearDensity, model: str) -> None:
    """Refuse a centre of mass for which a linear density would be negative somewhere."""
    if density.reach <= (1 + ROUND_OFF) / 6:
        return
    terms = " + ".join(
        f"{abs(e):.3g}/{size:g}" for e, size in zip(density.off, density.sizes, strict=True)
    )
    alone = ", ".join(f"{size / 6:.3g} m" for size in density.sizes)
    helps = "give inertia, or parts" if model == "rigid" else "give parts"
    raise Statement(
        "centre_of_mass",
        f"is off the middle by {terms} = {density.reach:.3g}; a density that varies linearly "
        f"allows 1/6 (each alone {alone}): {helps}",
    )


def inertia_tensor(given: Any) -> Tensor:
    """The tensor of a number (in the plane, about any axis), of three moments, or of a table."""
    if isinstance(given, float):
        given = (given,) * 3
    if not isinstance(given[0], float):
        return tensor_of(given)
    x, y, z = given
    return (x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)


def refuse_inertia(given: Any) -> None:
    """Refuse moments of inertia that no body has."""
    if isinstance(given, float):
        return
    if isinstance(given[0], tuple):
        moments = _principal(given)
    else:
        moments = sorted(given)
    if moments[0] <= ROUND_OFF * moments[2]:
        raise Statement("inertia", f"is not positive definite: {shown(given)}")
    if moments[2] > (1 + ROUND_OFF) * (moments[0] + moments[1]):
        three = ", ".join(f"{moment:.4g}" for moment in moments)
        said = f"is that of no body: of its principal moments {three} the last exceeds the sum of "
        raise Statement("inertia", f"{said}the others")


def refuse_spread(
    given: Any,
    mass: float,
    centre: Sequence[float],
    low: Sequence[float],
    high: Sequence[float],
) -> None:
    """Refuse moments of inertia that no mass has about a centre within a box, by its corners, m.

    Along each axis its mean square distance from the centre c is (b - c)(c - a) at most, all of it
    at the ends a and b (Bhatia and Davis, Amer. Math. Monthly 107, 2000).
    """
    most = [mass * (b - c) * (c - a) for a, c, b in zip(low, centre, high, strict=True)]
    if isinstance(given, float):
        if given > (1 + ROUND_OFF) * sum(most):
            allowed = f"at most {sum(most):.4g}, with all its {mass:.4g} kg at its corners"
            raise SceneError("inertia", shown(given), allowed)
        return
    tensor = inertia_tensor(given)
    half = sum(tensor[k][k] for k in range(3)) / 2
    for k, axis in enumerate("xyz"):
        if half - tensor[k][k] > (1 + ROUND_OFF) * most[k]:
            spread, reach = (math.sqrt(value / mass) for value in (half - tensor[k][k], most[k]))
            got = f"{shown(given)}, {mass:.4g} kg spread by {spread:.3g} m along {axis}"
            raise SceneError("inertia", got, f"at most {reach:.3g} m, all of it at both ends")


def _principal(table: Tensor) -> list[float]:
    """Principal moments of a table, sorted; SceneError if it is not symmetric."""
    import numpy as np  # scenes without such a table do not need it

    tensor = np.array(table)
    if np.abs(tensor - tensor.T).max() > ROUND_OFF * np.abs(tensor).max():
        raise SceneError("inertia", shown(table), "a symmetric table")
    return [float(moment) for moment in np.linalg.eigvalsh(tensor)]
