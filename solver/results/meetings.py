"""How bodies met in a run, and in which order blocks came down: the first entries of a summary."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.history.events import Event
from solver.history.history import History
from solver.scene import Scene
from solver.scene.laws import GROUND

STRIKING = ("collision", "impact", "landing")
"""Kinds of events in which two bodies come together."""


LISTED = 8
"""Blocks that come down, at most, of which a line tells."""


@dataclass(frozen=True, slots=True)
class Contacts:
    """The account that an engine keeps of its contacts."""

    deepest: tuple[float, float, str, str] | None
    """The largest overlap of two bodies: depth (m), time (s), both names; None: there was none."""
    unsettled: int
    """Steps that were taken though no solution met the tolerance."""
    largest_defect: float
    """Largest error of velocity in them, m/s."""


def meetings(
    scene: Scene, history: History, events: Sequence[Event], contacts: Contacts | None
) -> dict[str, Any]:
    """Entries of a summary: deepest penetration, collisions, chain of collapse, accuracy."""
    told = (contacts and contacts.deepest, _deepest(scene, history))
    deepest = max((each for each in told if each), key=lambda each: each[0], default=None)
    depth, at, *names = deepest or (None, None)
    met = [e for e in events if e.kind in STRIKING and e.meets != GROUND]
    blocks = {block.name: block for block in scene.blocks}
    pounding = [
        e for e in met if e.kind == "collision" and blocks[e.block].is_beside(blocks[e.meets])
    ]
    most = max(pounding, key=lambda event: event.impulse_Ns, default=None)
    unsettled = None
    if contacts is not None and contacts.unsettled:
        unsettled = {"steps": contacts.unsettled, "largest_defect_m_s": contacts.largest_defect}
    return {
        "deepest_penetration_m": depth,
        "deepest_penetration_at_s": at,
        "deepest_penetration_between": names or None,
        "first_collision": _told(met[0]) if met else None,
        "largest_pounding": most and {**_told(most), "impulse_Ns": most.impulse_Ns},
        "collapse": _collapse(events),
        "unsettled": unsettled,
    }


def _told(event: Event) -> dict[str, Any]:
    """Time and names of a collision."""
    return {"time_s": event.time_s, "between": [event.block, event.meets]}


def _deepest(scene: Scene, history: History) -> tuple[float, float, str, str] | None:
    """The largest penetration of a block in what carries it, by the rows of a history."""
    found = []
    for block in scene.blocks:
        depth = history[f"{block.name}.penetration_m"]
        if not np.any(depth > 0):
            continue
        row = int(np.nanargmax(depth))
        found.append((float(depth[row]), float(history["time_s"][row]), block.name, block.carrier))
    return max(found, default=None)


def _collapse(events: Sequence[Event]) -> list[dict[str, Any]]:
    """Blocks that overturned or fell, in the order in which they began to, and what they struck.

    A block begins to come down with the end of its last swing before; what it strikes from there on
    it strikes on its way down.
    """
    chain: dict[str, dict[str, Any]] = {}
    for event in events:
        if event.kind in ("overturned", "fell") and event.block not in chain:
            chain[event.block] = {
                "block": event.block,
                "how": event.kind,
                "time_s": event.time_s,
                "struck": _struck(events, event),
            }
    return list(chain.values())


def _struck(events: Sequence[Event], end: Event) -> list[str]:
    """Names of bodies that a block strikes up to the ground, in their order, each once."""
    swings = (e.time_s for e in events if (e.kind, e.block) == ("impact", end.block))
    begins = max((time for time in swings if time < end.time_s), default=-math.inf)
    found = [
        e.meets
        for e in events
        if e.kind in ("collision", "landing") and e.block == end.block and e.time_s > begins
    ]
    if GROUND in found:
        found = found[: found.index(GROUND) + 1]
    return list(dict.fromkeys(found))


def meeting_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """What there is to say of them, a line each."""
    if first := summary.get("first_collision"):
        one, other = first["between"]
        at = f"{first['time_s']:.4f} s"
        yield f"first collision of two blocks: {one} meets {other} at {at}"
    if most := summary.get("largest_pounding"):
        one, other = most["between"]
        impulse = f"{most['impulse_Ns']:.4g} N s"
        yield f"largest pounding: {one} on {other}, {impulse} at {most['time_s']:.4f} s"
    chain = summary.get("collapse", ())
    for fallen in chain[:LISTED]:
        struck = f", strikes {_listed(fallen['struck'])}" if fallen["struck"] else ""
        how = "overturns" if fallen["how"] == "overturned" else "falls"
        yield f"collapse: {fallen['block']} {how} at {fallen['time_s']:.4f} s{struck}"
    if len(chain) > LISTED:
        yield f"collapse: {len(chain) - LISTED} more blocks come down after them"
    if unsettled := summary.get("unsettled"):
        steps = unsettled["steps"]
        yield (
            f"{steps} {'step' if steps == 1 else 'steps'} found no solution within the tolerance: "
            f"contact is right there to {unsettled['largest_defect_m_s']:.2g} m/s, and so are the "
            "results"
        )


def _listed(names: Sequence[str]) -> str:
    """Names in a sentence."""
    named = ["the ground" if name == GROUND else name for name in names]
    return named[0] if len(named) == 1 else f"{', '.join(named[:-1])} and {named[-1]}"
