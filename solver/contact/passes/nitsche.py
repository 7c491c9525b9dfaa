"""The interface of a meshed body whose passes are one compiled call each."""

from __future__ import annotations

from solver.contact.body_points import NitschePoints, SurfaceState
from solver.contact.increment import ForceWeights
from solver.contact.interface import Interface
from solver.contact.kernels.nitsche import NitscheState
from solver.types import Array, Indices

Pressed = tuple[Indices, Array, Array, Array, Array, float, float, float, bool, Array]
"""What passes that add forces take first, from `index` to `scale`."""


class NitscheInterface(Interface):
    """An interface whose points know the traction of their body.

    Its passes call the functions that an `Interface` of any points and carrier calls one by one.
    """

    points: NitschePoints

    def pressed(
        self, old: SurfaceState, new: SurfaceState, force: Array, weights: ForceWeights
    ) -> Pressed:
        """What a pass adds as forces: those of points between two states, and how they count."""
        assert isinstance(old, NitscheState) and isinstance(new, NitscheState)
        (numbers, table, _), states = self.points.rows, (old.values, new.values)
        return numbers, table, *states, force, *weights, self.theta != 0, self.pull_scale
