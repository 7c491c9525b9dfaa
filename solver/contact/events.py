"""Changes of contact that shake the bodies: points that open, close, stick, slip or turn round."""

from __future__ import annotations

from collections.abc import Sequence

from solver.contact.kernels.memory import changed_forces
from solver.contact.memory import Memory

INTERFACE_SHARE = 1e-3
"""Part of the forces of an interface: points that carry less than it together shake nothing."""

TOTAL_SHARE = 1e-6
"""Part of the forces of all interfaces, likewise: a grazing interface has no other forces to be
compared with."""


def contact_changed(old: Sequence[Memory], new: Sequence[Memory], rigid: Sequence[bool]) -> bool:
    """Whether points that carry something changed their state of contact in a step.

    By the memories of all interfaces before and after it; `rigid`: neither body that touches is
    meshed.
    """
    changes = [
        changed_forces(before.force, after.force, before.past, after.past, alone)
        for before, after, alone in zip(old, new, rigid, strict=True)
        if not after.clear  # far from contact at both ends
    ]
    least = TOTAL_SHARE * sum(carried for _, carried in changes)
    return any(shaken > max(INTERFACE_SHARE * carried, least) for shaken, carried in changes)
