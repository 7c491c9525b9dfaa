"""Columns of links in a history, and what happens to links, by the numbers that engines have."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from solver.history.engine_rows import along
from solver.history.events import Event
from solver.kernels.world import LinkStates
from solver.law.links import laws_of
from solver.scene.link import LinkSpec
from solver.types import Array

SLACK, TAUT, FLOWED, BROKEN = range(4)
"""States of a link, as the history has them."""


class LinkRows:
    """Writer of the columns of links, and of what happens to them."""

    def __init__(self, specs: Sequence[LinkSpec], d: int):
        """Find their laws in d dimensions."""
        self._specs, self._d = specs, d
        self._laws = [laws_of(spec, d) for spec in specs]

    def columns(self, numbers: Array) -> dict[str, Array]:
        """The columns by the numbers of all links at the ends of steps."""
        states, known = LinkStates.split(self._d, numbers), {}
        for number, spec in enumerate(self._specs):
            own = 0 if spec.is_axial else self._d - 1
            known[f"{spec.name}.extension_m"] = states.extension[:, number, own]
            known[f"{spec.name}.state"] = self._state(states, number)
            known[f"{spec.name}.force_N"] = states.force[:, number, own]
            if not spec.is_axial:
                shear = states.force[:, number, : self._d - 1].T
                known |= along(f"{spec.name}.shear_force{{}}_N", shear)
        return known

    def _state(self, states: LinkStates, number: int) -> Array:
        """The states of a link; axes along which it is never slack count where it has no others."""
        laws = self._laws[number]
        slackens = [i for i, law in enumerate(laws) if law.gap > 0 or not law.compression]
        taut = np.full(len(states.broken), not slackens)
        for i in slackens:
            elastic = states.extension[:, number, i] - states.plastic[:, number, i]
            taut |= elastic > laws[i].gap
            if laws[i].compression:
                taut |= elastic < -laws[i].gap
        found = np.where(taut, TAUT, SLACK)
        found = np.where(np.any(states.plastic[:, number] != 0, axis=1), FLOWED, found)
        return np.where(states.broken[:, number], BROKEN, found)

    def events(self, numbers: Array, times: Array) -> Iterator[Event]:
        """Links that break or flow for the first time after the first step, whose ends have times.

        Args:
            numbers: Of all links at the ends of steps that were taken, and of the one before them.
            times: At the ends of all but that, s.
        """
        states = LinkStates.split(self._d, numbers)
        flowed = np.any(states.plastic != 0, axis=2)
        for number, spec in enumerate(self._specs):
            block, meets = spec.joined
            about: dict[str, Any] = {"block": block, "meets": meets, "where": spec.name}
            for row in np.flatnonzero(np.diff(flowed[:, number])):
                force = spec.yields or math.nan
                yield Event(time_s=float(times[row]), kind="yield", **about, force_N=force)
            for row in np.flatnonzero(np.diff(states.broken[:, number])) + 1:
                yield Event(
                    time_s=float(states.broken_at[row, number]),
                    kind="break",
                    **about,
                    energy_lost_J=float(states.lost[row, number]),
                    force_N=spec.strength or math.nan,
                )
