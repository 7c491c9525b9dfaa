"""Changes of contact that shake the bodies: points that open, close, stick, slip or turn round."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.contact.memory import Memory
from solver.types import Array, Mask

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
    states = [
        _changed(before, after, alone) for before, after, alone in zip(old, new, rigid, strict=True)
    ]
    if not any(changed.any() for changed in states):
        return False
    carried = [np.maximum(_sizes(a), _sizes(b)) for a, b in zip(old, new, strict=True)]
    least = TOTAL_SHARE * sum(float(sizes.sum()) for sizes in carried)
    return any(
        float(sizes[changed].sum()) > max(INTERFACE_SHARE * float(sizes.sum()), least)
        for changed, sizes in zip(states, carried, strict=True)
    )


def _changed(old: Memory, new: Memory, rigid: bool) -> Mask:
    """Points of an interface that opened, closed, stuck, slipped or turned round."""
    before, after = old.force, new.force
    slipped = _slipping(old, rigid)
    states = (before[:, 0] > 0) != (after[:, 0] > 0)
    states |= slipped != _slipping(new, rigid)
    states |= slipped & ((before[:, 1:] * after[:, 1:]).sum(axis=1) < 0)
    return states


def _slipping(memory: Memory, rigid: bool) -> Mask:
    """Points that slip; which of those of two rigid bodies do is chance, unless all of them do."""
    if not rigid:
        return memory.slipped
    closed = memory.force[:, 0] > 0
    return closed & bool(memory.slipped[closed].all())


def _sizes(memory: Memory) -> Array:
    """Magnitudes of point forces, N."""
    return np.asarray(np.linalg.norm(memory.force, axis=1), dtype=np.float64)
