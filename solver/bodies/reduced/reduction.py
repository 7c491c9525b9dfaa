"""What became of the mesh of a reduced body, in numbers and in words."""

from __future__ import annotations

import math
from typing import NamedTuple

from solver.bodies.reduced.body import ReducedFacts
from solver.bodies.reduced.craig_bampton import Bound, InnerBasis


class Reduction(NamedTuple):
    """What became of a mesh, in numbers that every rank knows."""

    facts: ReducedFacts
    """The body."""
    modes: int
    """Number of modes."""
    shapes: int
    """Number of static shapes besides."""
    fastest: float
    """Frequency of the fastest mode, rad/s."""
    bound: Bound
    """What the modes left out may take."""
    touched: int
    """Number of nodes kept on the deck."""
    supported: int
    """Number of nodes kept at supports besides."""

    @classmethod
    def of(cls, facts: ReducedFacts, basis: InnerBasis, nodes: tuple[int, int]) -> Reduction:
        """The numbers of a basis, and those of nodes that are kept on the deck and at supports."""
        modes = basis.modes
        fastest = math.sqrt(float(basis.squared[modes - 1])) if modes else 0.0
        return cls(facts, modes, len(basis.squared) - modes, fastest, basis.bound, *nodes)

    def in_words(self) -> tuple[str, str, str, str]:
        """Unknowns, modes, nodes, and what modes left out may take."""
        bound, hertz = self.bound, 2 * math.pi
        highest = f"{bound.frequency / hertz:.3g} Hz"
        left = f"{100 * bound.part:.2g} %" if bound.part < math.inf else "any part"
        return (
            f"{self.facts.unknowns} unknowns instead of {self.facts.full_unknowns}",
            f"{self.modes} up to {self.fastest / hertz:.4g} Hz, and {self.shapes} static shapes",
            f"{self.touched} of the top, {self.supported} at supports",
            f"take at most {left} of mass times acceleration, up to {highest}",
        )
