"""What several ranks gain or cost, before a run: a model of the time of a step, from measurements.

    t(p) = o + b N/p + sum over bodies s E + m log2(p),      N unknowns, E entries of a factor

with what Python does whatever the size (o), work on cells and nodes, which ranks share (b), back
substitutions, which the first of a few ranks does for all (s), and messages (m).
"""

from __future__ import annotations

import math

from solver.bodies.memory import ALONE_RANKS, factor_entries, has_vector_factor
from solver.scene import Scene
from solver.scene.cells import box_nodes

FIXED = 1e-3
"""o, s: a step of the demo, nearly all of it."""

SHARED = {2: 0.3e-6, 3: 0.85e-6}
"""b, s: residuals, energies, products of 4 corrections, measured at 52 670 and 41 616 unknowns."""

SOLVED = {2: 11e-9, 3: 4e-9}
"""s, s: back substitutions of 4 corrections, likewise, with CHOLMOD's factor."""

OWN_FACTOR = 0.5
"""The part of it that vectors with a factor of their own take."""

MESSAGES = 2e-3
"""m, s: between two ranks on one machine, each on a processor of its own. The demo is 1.1 to 5
times slower on two ranks, which is 0.1 to 5 ms a step."""

WORTH_SAYING = 1.05
"""Ratio of times from which on ranks are called slower."""


def unknowns_of(scene: Scene) -> list[int]:
    """Unknowns of each body of a scene that steps go on with as a mesh."""
    d, foundation = scene.dimension, scene.foundation
    blocks = [d * box_nodes(block) for block in scene.blocks if block.model != "rigid"]
    carrier = 0 if foundation.reduced_modes is not None else foundation.unknowns(d)
    return [size for size in (*blocks, carrier) if size]


def step_time(sizes: list[int], dimension: int, ranks: int) -> float:
    """t(p) of meshed bodies of so many unknowns each, s."""
    read = 0.0
    for size in sizes:
        entries = factor_entries(size, dimension)
        has_own = ranks <= ALONE_RANKS and has_vector_factor(entries, dimension)
        read += entries * (OWN_FACTOR if has_own else 1.0)
    own = SHARED[dimension] * sum(sizes) / ranks + SOLVED[dimension] * read
    return FIXED + own + MESSAGES * math.log2(ranks)


def slower_by(scene: Scene, ranks: int) -> float:
    """Time of a step on so many ranks over that on one; 1 where nothing is meshed."""
    sizes = unknowns_of(scene)
    if ranks == 1 or not sizes:
        return 1.0
    return step_time(sizes, scene.dimension, ranks) / step_time(sizes, scene.dimension, 1)


def enough_unknowns(dimension: int, ranks: int) -> float:
    """Unknowns from which on so many ranks are faster than one."""
    return MESSAGES * math.log2(ranks) / (SHARED[dimension] * (1 - 1 / ranks))


def ranks_in_words(scene: Scene, ranks: int) -> str:
    """What so many ranks are expected to cost; empty where they are not slower than one."""
    ratio, sizes = slower_by(scene, ranks), unknowns_of(scene)
    if ratio < WORTH_SAYING:
        return ""
    least = 1000 * round(enough_unknowns(scene.dimension, ranks) / 1000)
    return (
        f"{ranks} ranks are expected to take {ratio:.2g} times as long as one: "
        f"{sum(sizes)} unknowns, ranks pay from about {least} on"
    )
