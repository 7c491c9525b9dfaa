"""Boundaries of overturning: an engine, a pulse, a frequency, a restitution; rounds of them.

Frequencies are added where the intervals of two neighbours differ.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import pairwise, product

import numpy as np

from geometry.block import SIDES
from solver.errors import SceneError, Statement
from solver.scene import Scene
from solver.study.overturning.blocks import PULSES, RigidUnderPulses, elastic_fate
from solver.study.overturning.boundaries import STAYS, Boundary, boundaries, near
from solver.study.overturning.numbers import NAMES, as_text, boundary_rows, differences, kinds
from solver.study.scenes import Tables, is_elastic, standing_block, variant
from solver.study.study import Row, Study, numbers, words

ENOUGH_FRICTION = 1.7
"""Friction with which no block slides that a sudden acceleration can rock (Shenton 1996)."""

MOST_FREQUENCIES = 6
"""Frequencies for which there is a picture over restitution."""

TOLERANCE = {"rigid": 1e-5, "elastic": 2e-3}
"""Relative, of the amplitudes of boundaries."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OverturningCase:
    """One engine, one pulse, one frequency, one restitution.

    Attributes:
        engine: "rigid" or "elastic".
        pulse: Its kind.
        frequency: omega/p.
        restitution: e of a rigid block; None: plastic impacts, or an elastic block.
        tables: The scene.
        amplitudes: Over g tan alpha: of the scan of a rigid block, increasing.
        rigid: Of an elastic block, the boundaries of the rigid one: amplitude, below, above.
    """

    engine: str
    pulse: str
    frequency: float
    restitution: float | None
    tables: Tables
    amplitudes: tuple[float, ...] = ()
    rigid: tuple[tuple[float, str, str], ...] = ()

    @property
    def name(self) -> str:
        """Its own in the study; also the name of its file."""
        e = "" if self.restitution is None else f",e={self.restitution:g}"
        beside = "".join(f",{amplitude:.8g}" for amplitude, _, _ in self.rigid)
        return f"{self.engine},{self.pulse},frequency={self.frequency:.8g}{e}{beside}"

    def scene(self) -> Scene:
        """The scene with a rigid block; its impacts are plastic where no restitution is given."""
        return variant(self.tables, model="rigid", restitution=self.restitution)

    def run(self) -> Row:
        """Find the boundaries on one process; the row of the case, with a list of them."""
        pulse, tolerance = PULSES[self.pulse], TOLERANCE[self.engine]
        if self.engine == "rigid":
            block = RigidUnderPulses(self.scene(), pulse, self.frequency)
            found = boundaries(block, self.amplitudes, tolerance)
        else:
            fate = partial(elastic_fate, self.tables, pulse, self.frequency)
            ends = ((near(fate, *edge, tolerance), edge) for edge in self.rigid if STAYS in edge)
            found = [Boundary(sum(both) / 2, *edge[1:]) for both, edge in ends if both]
        return {
            "engine": self.engine,
            "pulse": self.pulse,
            "frequency": self.frequency,
            "restitution": self.restitution,
            "boundaries": [asdict(each) for each in found],
        }


def scan(low: float, high: float, samples: int) -> tuple[float, ...]:
    """Amplitudes of a scan, in a geometric series."""
    return tuple(float(value) for value in np.geomspace(low, high, samples))


class OverturningStudy(Study[OverturningCase]):
    """Which pulses overturn a block: amplitude against frequency, all intervals of amplitude.

    Attributes:
        tables: The scene.
        pulses: Their kinds.
        frequencies: omega/p, increasing, also those of elastic blocks.
        restitutions: e of rigid blocks; None: that of the scene, or plastic impacts.
        amplitudes: Of the scan, over g tan alpha.
        elastic: Frequencies at which elastic blocks run, too.
    """

    kind, noun = "overturning", "study of overturning"
    same = "the same scene, amplitudes and samples"
    files = ("restitution.png",)

    def __init__(self, options: argparse.Namespace):
        """Read the command line."""
        super().__init__(options)
        scanned = numbers("--amplitudes", options.amplitudes)
        if options.amplitudes.count(":") != 2 or len(scanned) < 3 or scanned[-1] <= scanned[0]:
            raise SceneError("--amplitudes", options.amplitudes, "LOW:HIGH:COUNT, COUNT >= 3")
        restitutions = numbers("--restitution", options.restitution)
        if any(e > 1 for e in restitutions):
            raise SceneError("--restitution", options.restitution, "0 < e <= 1")
        if not 0 <= options.rounds <= 10:
            raise SceneError("--rounds", f"{options.rounds}", "0 <= rounds <= 10")
        self.tables = standing_block(options)
        if options.elastic and not is_elastic(self.tables):
            raise Statement("block", "has no young and poisson, which --elastic needs")
        self.elastic = numbers("--elastic", options.elastic)
        self.pulses = words("--pulses", options.pulses, tuple(PULSES))
        own = numbers("--frequencies", options.frequencies)
        self.frequencies = sorted({*own, *self.elastic})
        self.restitutions = restitutions or [self.tables["block"][0].get("restitution")]
        self.amplitudes = scan(scanned[0], scanned[-1], len(scanned))
        scene = variant(self.tables).to_dict()
        self.settings = {"scene": scene, "amplitudes": list(self.amplitudes)}

    def rounds(self) -> Iterator[Sequence[OverturningCase]]:
        """Rigid blocks, those between neighbours that differ, elastic ones."""
        yield [
            self._rigid(pulse, frequency, e)
            for pulse in self.pulses
            for e in self.restitutions
            for frequency in self.frequencies
        ]
        for _ in range(self.options.rounds):
            yield list(self._between())
        yield list(self._elastic())

    def _rigid(self, pulse: str, frequency: float, restitution: float | None) -> OverturningCase:
        """The case of a rigid block."""
        return OverturningCase(
            engine="rigid",
            pulse=pulse,
            frequency=frequency,
            restitution=restitution,
            tables=self.tables,
            amplitudes=self.amplitudes,
        )

    def _between(self) -> Iterator[OverturningCase]:
        """Rigid blocks midway between neighbours whose intervals are not of the same kinds."""
        for pulse in self.pulses:
            for e in self.restitutions:
                own = [r for r in self.completed if (r["pulse"], r["restitution"]) == (pulse, e)]
                for low, high in pairwise(sorted(own, key=lambda row: row["frequency"])):
                    if kinds(low) != kinds(high):
                        middle = (low["frequency"] + high["frequency"]) / 2
                        yield self._rigid(pulse, float(f"{middle:.6g}"), e)

    def _elastic(self) -> Iterator[OverturningCase]:
        """Elastic blocks, at the boundaries of the rigid one."""
        for pulse, frequency in product(self.pulses, self.elastic):
            case = self._rigid(pulse, frequency, self.restitutions[0])
            row = self.rows.get(case.name, {})
            if row.get("status") == "completed":
                edges = ((b["amplitude"], b["below"], b["above"]) for b in row["boundaries"])
                made = replace(case, engine="elastic", restitution=None)
                yield replace(made, amplitudes=(), rigid=tuple(edges))

    def write(self) -> str:
        """Write the boundaries, differences from the rigid block, the pictures."""
        done = self.completed
        if not done:
            return ""
        edges = boundary_rows(done, self.restitutions[0])
        text = as_text(edges)
        counts = {"cases": len(self.cases), "completed": len(done)}
        summary = counts | {"largest_difference": differences(edges)}
        self.leave(edges, text, summary, names=NAMES)
        self._draw(done)
        return text

    def _draw(self, done: list[Row]) -> None:
        """Draw the pictures."""
        from solver.study.overturning.picture import overturning_picture

        e, top = self.restitutions[0], self.amplitudes[-1]
        rigid = [row for row in done if row["engine"] == "rigid"]
        first = [row for row in rigid if row["restitution"] == e]
        elastic = [row for row in done if row["engine"] == "elastic"]
        frequencies = {row["frequency"] for row in rigid}
        if len(frequencies) > 1:
            told = elastic, self._title(e), top
            self.draw("overturning.png", overturning_picture, "frequency", first, *told)
        if len(self.restitutions) > 1 and len(frequencies) <= MOST_FREQUENCIES:
            told = [], self._title(), top
            self.draw("restitution.png", overturning_picture, "restitution", rigid, *told)

    def _title(self, restitution: float | None = None) -> str:
        """Slenderness, restitution and friction of the rigid block, in words."""
        scene = variant(self.tables, model="rigid")
        block = scene.blocks[0]
        parts = [f"H/B = {block.height / block.width:g}"]
        if len(self.restitutions) == 1 or restitution is not None:
            own = [max(0.0, block.shape.restitution(side)) for side in SIDES]
            given = [restitution] if restitution else dict.fromkeys(own)
            parts.append(f"e = {' and '.join(f'{each:.4g}' for each in given)}")
            if restitution is None:
                parts[-1] += " (Housner's)"
        mu = scene.friction_of(block).dynamic
        parts.append(f"mu = {mu:g}" + (", blocks may slide" if mu < ENOUGH_FRICTION else ""))
        return ", ".join(parts)
