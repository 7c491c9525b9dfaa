"""What interfaces did in a step: impulses on bodies, where, and how far they slipped."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.contact.kinematics import in_space
from solver.contact.memory import Memory
from solver.contact.pairs import Link
from solver.stepping.balance import Contact
from solver.stepping.state import Push
from solver.types import Array


def pushes(
    links: Sequence[Link],
    start: Sequence[Memory],
    contacts: Sequence[Contact],
    impulse: Array | None,
    dt: float,
    *,
    homes: bool,
) -> list[Push]:
    """What interfaces near contact did in a step of length dt (s).

    Args:
        links: The interfaces.
        start: Their memories at its start, in its frame.
        contacts: What they are at its end.
        impulse: Impulses at velocity level of all points, (points, d), N s; None: there are none.
        dt: The length.
        homes: True if also those between a block and what carries it are told.
    """
    found, first = [], 0
    for link, before, after in zip(links, start, contacts, strict=True):
        interface, own = link.interface, slice(first, first + link.interface.count)
        first = own.stop
        if link.stands and not homes:
            continue
        kinematics, force = after.kinematics, dt * after.force
        vectors = interface.carrier.vectors(before.kinematics, kinematics, force)
        total = force.copy()
        if impulse is not None:
            total += impulse[own]
            vectors = vectors + in_space(impulse[own], kinematics.frame)
        beyond = interface.carrier.beyond_edge(kinematics)
        near = before.may_touch if beyond is None else before.may_touch & ~beyond
        weight = total[:, 0]
        place = after.surface.position
        if kinematics.own_projection is not None:
            place = kinematics.own_projection.carried(place)
        slipped = kinematics.place - before.kinematics.place
        slipped[:, 0] = 0.0
        upright = np.zeros_like(total)
        upright[:, 0] = weight
        found.append(
            Push(
                body=link.body,
                carrier=link.carrier,
                impulse=vectors.sum(axis=0),
                normal=in_space(upright, kinematics.frame).sum(axis=0),
                moment=weight @ place,
                slip=in_space(weight[:, None] * slipped, kinematics.frame).sum(axis=0),
                pressed=float(weight.sum()),
                gap=float(kinematics.place[near, 0].min(initial=np.inf)),
                points=int(np.count_nonzero(after.force[:, 0] > 0)),
            )
        )
    return found
