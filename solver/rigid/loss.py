"""What rigid blocks lose in contact at velocity level, and what of it is friction; compiled."""

from __future__ import annotations

from solver.law.compiled import compiled


@compiled
def shares_of_loss(normal: float, tangential: float) -> tuple[float, float]:
    """Contact's and friction's share of the kinetic energy that impulses take, J.

    Normal and tangential impulses of a rigid block act on each other: the work in one direction may
    be negative, though their sum is a loss. A loss through friction cannot be negative: where the
    tangential impulses give energy back, the normal ones took it before, and it is contact's.

    Args:
        normal: Energy taken in the normal directions, J.
        tangential: In the tangential ones, J.
    """
    lost = normal + tangential
    friction = min(max(tangential, 0.0), max(lost, 0.0))
    return lost - friction, friction
