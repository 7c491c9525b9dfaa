"""Freight containers by name: `container = "20ft"` of a block."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

from solver.errors import SceneError
from solver.scene.feet import FootSpec, Plan
from solver.scene.quantities import Dimension

ContainerName: TypeAlias = Literal[
    "20ft", "20ft high cube", "40ft", "40ft high cube", "45ft", "45ft high cube"
]
Load: TypeAlias = Literal["empty", "full"]


class Container(NamedTuple):
    """Outer dimensions by ISO 668, from end to end of the corner castings, and an empty mass."""

    length: float
    """m."""
    height: float
    """m."""
    tare: float | None
    """A usual mass of an empty one, kg, which no standard sets; None: these are rare."""


CONTAINERS: dict[ContainerName, Container] = {
    "20ft": Container(6.058, 2.591, 2300.0),
    "20ft high cube": Container(6.058, 2.896, None),
    "40ft": Container(12.192, 2.591, 3750.0),
    "40ft high cube": Container(12.192, 2.896, 3940.0),
    "45ft": Container(13.716, 2.591, None),
    "45ft high cube": Container(13.716, 2.896, 4820.0),
}

WIDTH = 2.438
"""Of all of them, m (ISO 668)."""

GROSS_MASS = 30480.0
"""The largest mass of all of them, kg (ISO 668 since 2005; from 2016 on it allows 36 000 kg)."""

CASTING = (0.162, 0.178)
"""Sides of the faces of a corner casting along width and length, m (ISO 1161); it is 0.118 high."""

BELOW = 0.0125
"""By which the castings are below the underside of a container, m (ISO 668, its base)."""

ABOVE = 0.006
"""By which they are above its roof at least, m (ISO 1496-1)."""


def mass_of(name: ContainerName, load: Load) -> float:
    """Its mass, empty or full, kg; SceneError where that of an empty one is not known."""
    if load == "full":
        return GROSS_MASS
    tare = CONTAINERS[name].tare
    if tare is None:
        raise SceneError(
            "load", '"empty"', f'"full", or its mass instead: "{name}" has no usual one'
        )
    return tare


def sizes_of(name: ContainerName, scale: float) -> dict[str, float]:
    """Width, height and thickness of it as a block, its length across the plane, m."""
    kind = CONTAINERS[name]
    sizes = {"width": WIDTH, "height": kind.height, "thickness": kind.length}
    return {key: scale * size for key, size in sizes.items()}


def castings(name: ContainerName, scale: float, dimension: Dimension) -> tuple[FootSpec, ...]:
    """The ends of its corner castings, flush with its sides: four below, and four above.

    One of 45 feet has as many where one of 40 feet has them, too, to stand on it or carry it.
    """
    wide, long = (scale * side for side in CASTING)
    x = (scale * WIDTH - wide) / 2
    plans: list[Plan] = [(-x,), (x,)]
    if dimension == 3:
        lengths = {CONTAINERS[name].length, min(CONTAINERS[name].length, CONTAINERS["40ft"].length)}
        ends = [(scale * length - long) / 2 for length in sorted(lengths, reverse=True)]
        plans = [at for y in ends for at in ((-x, -y), (x, -y), (x, y), (-x, y))]
    size = (wide, long) if dimension == 3 else wide
    below = [FootSpec(at=at, size=size, height=scale * BELOW) for at in plans]
    above = [FootSpec(at=at, size=size, height=scale * ABOVE, face="top") for at in plans]
    return (*below, *above)
