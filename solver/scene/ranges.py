"""Ranges of numbers that several specifications share."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from solver.scene.checking import Number

Finite = Annotated[float, Number()]
Positive = Annotated[float, Number(above=0)]
NotNegative = Annotated[float, Number(at_least=0)]
Ratio = Annotated[float, Number(at_least=0, below=0.5)]
"""Poisson's ratio."""
Tilt = Annotated[float, Number(above=-90, below=90)]
Turn = Annotated[float, Number(at_least=-360, at_most=360)]
DampingRatio = Annotated[float, Number(at_least=0, below=1)]
"""xi, of critical damping."""
Count = Annotated[int, Number(at_least=1)]

Vector: TypeAlias = tuple[Finite, Finite] | tuple[Finite, Finite, Finite]
Rotation: TypeAlias = Finite | tuple[Finite, Finite, Finite]
"""A rotation or its rate; in the plane one number."""
Dimension: TypeAlias = Literal[2, 3]
Cells: TypeAlias = tuple[Count, Count] | tuple[Count, Count, Count]
"""Along width and height; in 3-D along width, thickness and height."""
Cell: TypeAlias = Literal["quadrilateral", "triangle", "hexahedron", "tetrahedron"]
