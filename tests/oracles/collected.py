"""All oracles by topic, and what a run of one gives."""

from __future__ import annotations

from typing import Any

from tests.oracles import (
    demos,
    elastic_ground,
    foundations,
    motions,
    neighbours,
    rigid_ground,
    space,
    stacks,
    studies,
)
from tests.oracles.oracle import Oracle, Value

TOPICS: dict[str, list[Oracle]] = {
    "rigid ground": rigid_ground.ORACLES,
    "elastic ground": elastic_ground.ORACLES,
    "space": space.ORACLES,
    "stacks": stacks.ORACLES,
    "foundations": foundations.ORACLES,
    "motions": motions.ORACLES,
    "studies": studies.ORACLES,
    "demos": demos.ORACLES,
    "neighbours": neighbours.ORACLES,
}

Row = tuple[float, str, str, Value, Any]


def rows(topic: str, place: int, beside: bool) -> list[Row]:
    """Of an oracle: difference over tolerance, oracle, number, value, what was found."""
    oracle = TOPICS[topic][place]
    found = []
    for what, changes in (oracle.beside if beside else {"": {}}).items():
        name = f"{topic}: {oracle.name}" + (f" [{what}]" if what else "")
        for number, value, got in oracle.differences(changes):
            if value.source == "today" or not beside:
                found.append((value.off(got), name, number, value, got))
    return found
