"""Links as films and stills draw them: lines between their ends, whole or broken."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.fields.links import LEFT
from solver.history.link_columns import BROKEN, FLOWED, SLACK, TAUT
from solver.pictures.contact import block_poses, drift_at
from solver.results.runs import Run
from solver.scene import LinkSpec
from solver.scene.laws import GROUND
from solver.scene.places import own_ends
from solver.types import Array

LOOKS = {
    SLACK: ("link, slack", "#8a8a8a"),
    TAUT: ("link, taut", "#202020"),
    FLOWED: ("link, has flowed", "#8e44ad"),
    BROKEN: ("link, broken", "#d62728"),
}
"""What links are called in legends, by their states, and their colours."""


@dataclass(frozen=True, slots=True, eq=False)
class LinkFrames:
    """A link over the frames of a film, or at the instants of stills."""

    ends: Array
    """Places of its ends, m, (n, 2, d)."""
    states: NDArray[np.int64]
    """Its states, (n,)."""

    def lines(self, frame: int, longest: float) -> list[Array]:
        """Lines that stand for it, (2, d) each, m; what is left of it where it is broken.

        That is no longer than a length, m.
        """
        first, second = self.ends[frame]
        if self.states[frame] != BROKEN:
            return [self.ends[frame]]
        apart = float(np.linalg.norm(second - first))
        part = min(LEFT, longest / apart) if apart else 0.0
        left = part * (second - first)
        return [np.stack([first, first + left]), np.stack([second, second - left])]


def links_of(run: Run, times: Array) -> list[LinkFrames]:
    """All links of a run at some times, s."""
    return [link_frames(run, link, times) for link in run.scene.links]


def link_frames(run: Run, link: LinkSpec, times: Array) -> LinkFrames:
    """A link at some times, s."""
    history, ends = run.history, []
    for name, own in zip(link.between, own_ends(link, run.scene.poses()), strict=True):
        if name == GROUND:
            ends.append(own + drift_at(run, times))
            continue
        block = next(each for each in run.scene.blocks if each.name == name)
        centres, frames = block_poses(run, block, times)
        ends.append(centres + frames @ (own - block.shape.middle(len(own))))
    before = np.searchsorted(history["time_s"], times, side="right") - 1
    states = history[f"{link.name}.state"][np.maximum(before, 0)]
    return LinkFrames(np.stack(ends, axis=1), states.astype(np.int64))


def states_in(links: Iterable[LinkFrames]) -> list[int]:
    """The states in which some links are, in their order."""
    return sorted({int(state) for link in links for state in link.states})


def legend_handles(states: Sequence[int]) -> list[Any]:
    """Handles for a legend of states."""
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], color=hue, linewidth=1.8, label=label)
        for label, hue in (LOOKS[state] for state in states)
    ]
