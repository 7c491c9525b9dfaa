"""Rounds of cases: frequencies are added where the intervals of two neighbours differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from solver.study.overturning.case import OverturningCase
from solver.study.standing import Tables

Rows = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """What a study is asked for.

    Attributes:
        tables: The scene.
        pulses: Their kinds.
        frequencies: omega/p.
        restitutions: e of rigid blocks; None: that of the scene, or plastic impacts.
        amplitudes: Of the scan, over g tan alpha.
        rounds: How often frequencies are added.
        beside: Frequencies at which other engines run, too: "ode", "elastic".
    """

    tables: Tables
    pulses: tuple[str, ...]
    frequencies: tuple[float, ...]
    restitutions: tuple[float | None, ...]
    amplitudes: tuple[float, ...]
    rounds: int
    beside: Mapping[str, tuple[float, ...]]

    def rigid(self, pulse: str, frequency: float, restitution: float | None) -> OverturningCase:
        """The case of a rigid block."""
        return OverturningCase(
            engine="rigid",
            pulse=pulse,
            frequency=frequency,
            restitution=restitution,
            tables=self.tables,
            amplitudes=self.amplitudes,
        )

    def first(self) -> list[OverturningCase]:
        """The rigid blocks at the frequencies that were asked for."""
        also = (frequency for given in self.beside.values() for frequency in given)
        frequencies = sorted({*self.frequencies, *also})
        return [
            self.rigid(pulse, frequency, e)
            for pulse in self.pulses
            for e in self.restitutions
            for frequency in frequencies
        ]

    def more(self, cases: Sequence[OverturningCase], rows: Rows) -> list[OverturningCase]:
        """Rigid blocks midway between neighbours whose intervals are not of the same kinds."""
        added = []
        for pulse in self.pulses:
            for e in self.restitutions:
                own = [c for c in cases if (c.pulse, c.restitution) == (pulse, e)]
                done = sorted((c for c in own if good(rows, c)), key=lambda case: case.frequency)
                for low, high in pairwise(done):
                    if kinds(rows[low.name]) != kinds(rows[high.name]):
                        middle = float(f"{(low.frequency + high.frequency) / 2:.6g}")
                        added.append(self.rigid(pulse, middle, e))
        return added

    def others(self, rows: Rows) -> list[OverturningCase]:
        """The other engines, at the boundaries of the rigid block."""
        found = []
        for engine, frequencies in self.beside.items():
            restitutions = self.restitutions if engine == "ode" else self.restitutions[:1]
            for pulse in self.pulses:
                for e in restitutions:
                    for frequency in frequencies:
                        case = self.rigid(pulse, frequency, e)
                        if good(rows, case):
                            found.append(_beside(case, engine, rows[case.name]))
        return found


def _beside(case: OverturningCase, engine: str, row: Mapping[str, Any]) -> OverturningCase:
    """The case of another engine at the boundaries of a rigid block."""
    edges = tuple((b["amplitude"], b["below"], b["above"]) for b in row["boundaries"])
    e = None if engine == "elastic" else case.restitution
    return replace(case, engine=engine, restitution=e, amplitudes=(), rigid=edges)


def good(rows: Rows, case: OverturningCase) -> bool:
    """Whether a case has been done."""
    return case.name in rows and rows[case.name]["status"] == "completed"


def kinds(row: Mapping[str, Any]) -> tuple[str, ...]:
    """What comes of pulses from the least amplitude to the largest, in words."""
    edges = row["boundaries"]
    return tuple(edge["below"] for edge in edges) + tuple(edge["above"] for edge in edges[-1:])
