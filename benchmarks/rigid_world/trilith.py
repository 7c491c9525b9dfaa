"""A trilith under half sines of the ground: does it rest, move or collapse?

    ./in-env python3 -m benchmarks.rigid_world.trilith [--points N]

Two columns of 0.5 m x 2 m and a lintel under half sines, with friction that prevents sliding (3.0),
a little more than rocking needs (0.3; tan alpha is 0.25), and less (0.2). Writes
`benchmarks/trilith.csv`, a row for each pulse, and `docs/pictures/trilith.png`: maps over frequency
and amplitude as Andreaus and Casini (1999) drew them, beside the rocking frame of Makris and
Vassiliou (2013). Takes three minutes of processor time.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from scipy.optimize import brentq

from benchmarks.rigid_world import scenes
from benchmarks.rows import Row, write_table
from geometry.block import Block
from rockslip import parse_scene
from solver.excitation.motion import read_ground
from solver.reference.housner import RockingReference, housner
from solver.rigid.system import RigidSystem
from solver.types import Array

TABLE = Path(__file__).resolve().parents[1] / "trilith.csv"
PICTURE = TABLE.parents[1] / "docs" / "pictures" / "trilith.png"
FRICTION = (3.0, 0.3, 0.2)
STATES = ("rest", "motion", "collapse")
MOVED = 1e-6
"""A trilith has moved if a centre went as far sideways, over the height of the columns."""


@dataclass(frozen=True, slots=True)
class Frame:
    """Columns that rock in parallel under a lintel (Makris and Vassiliou, 2013).

    theta'' = -p^2 (1 + 2 gamma)/(1 + 3 gamma) (sin(alpha - theta) + a/g cos(alpha - theta)), with
    p^2 = 3 g/(4 R) and gamma the mass of the lintel over that of both columns: one block of the
    same slenderness alpha, with 1.5 times the size if the lintel is heavy.
    """

    block: Block

    @classmethod
    def of(cls, tables: dict[str, Any]) -> Self:
        """The frame of a trilith's scene."""
        column, _, lintel = tables["block"]
        gamma = scenes.weight(lintel) / (2 * scenes.weight(column))
        size = (1 + 3 * gamma) / (1 + 2 * gamma)
        width, height = size * column["width"], size * column["height"]
        return cls(Block(width=width, height=height, thickness=1.0, density=1.0))

    @property
    def alpha(self) -> float:
        """Slenderness of a column, rad."""
        return self.block.slenderness()

    def rocking(
        self, amplitude: float, duration: float, end: float, rows: int = 50
    ) -> RockingReference:
        """Motion of the frame under half a sine of an amplitude (g) and a duration (s).

        It ends with the first impact, and has `rows` rows within the pulse.
        """

        def ground(time: float) -> float:
            shaken = math.sin(math.pi * time / duration) if time < duration else 0.0
            return amplitude * scenes.G * shaken

        return housner(
            self.block,
            gravity=scenes.G,
            end=end,
            step=duration / rows,
            acceleration=ground,
            restitution=0.0,
            tolerance=1e-8,
        )

    def angle(self, amplitude: float, duration: float, times: Array) -> Array:
        """Angle of the columns before their first impact, rad, positive towards +x."""
        found = self.rocking(amplitude, duration, float(times[-1]), rows=1000)
        if len(found.impacts):
            raise ValueError("the frame lands before the last time")
        return np.interp(times, found.time, found.angle)

    def overturning(self, duration: float) -> float:
        """Least amplitude, g, of a half sine that overturns it before any impact."""

        def lands(amplitude: float) -> float:
            found = self.rocking(amplitude, duration, 10.0)
            return 1.0 if found.overturned and not len(found.impacts) else -1.0

        low, high = math.tan(self.alpha) * 1.0001, 100.0
        return float(brentq(lands, low, high, xtol=1e-6, rtol=1e-9))


def outcome(amplitude: float, duration: float, *, end: float = 5.0, **trilith: Any) -> str:
    """Rest, motion or collapse: a column or the lintel has gone down by a quarter of a column."""
    motion = {"kind": "half_sine", "amplitude_g": amplitude, "duration": duration}
    given = parse_scene(scenes.trilith(motion=motion, **trilith))
    system, ground, dt = RigidSystem(given), read_ground(given), 1e-3
    across = [k for k, name in enumerate(system.columns) if name.endswith(".centre_x_m")]
    places = np.array([system.centre(k) for k in range(3)])
    height, moved = given.blocks[0].shape.height, 0.0
    while system.time < end:
        times = system.time + dt * np.arange(201)
        means = ground.means(times)
        done = system.advance(200, dt, ground.acceleration(times), mean=means)
        if done.failure:
            return done.failure
        moved = max(moved, float(np.abs(done.rows[:, across] - places[:, 0]).max()))
        if system.centre(2)[1] < places[2, 1] - height / 4:
            return "collapse"
    return "rest" if moved < MOVED * height else "motion"


def rows(points: int) -> Iterator[Row]:
    """The rows of the map: for each friction, frequency and amplitude."""
    frame = Frame.of(scenes.trilith())
    for friction in FRICTION:
        for frequency in np.linspace(0.5, 3.0, points):
            duration = 0.5 / float(frequency)
            least, falls = math.tan(frame.alpha), frame.overturning(duration)
            for amplitude in np.linspace(0.1, 2.0, points):
                a = float(amplitude)
                yield {
                    "friction": friction,
                    "frequency_Hz": f"{frequency:.4g}",
                    "amplitude_g": f"{a:.4g}",
                    "outcome": outcome(a, duration, friction=friction),
                    "frame": STATES[(a > least) + (a > falls)],
                }


def draw(found: Sequence[Row]) -> None:
    """The picture of the maps."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(FRICTION), figsize=(11, 3.6), sharey=True)
    frame = Frame.of(scenes.trilith())
    frequency = np.linspace(0.5, 3.0, 60)
    falls = [frame.overturning(0.5 / float(f)) for f in frequency]
    for axis, friction in zip(axes, FRICTION, strict=True):
        for state, colour in zip(STATES, ("0.8", "tab:blue", "tab:red"), strict=True):
            at = [row for row in found if row["friction"] == friction and row["outcome"] == state]
            places = ([float(row[key]) for row in at] for key in ("frequency_Hz", "amplitude_g"))
            axis.plot(*places, "s", color=colour, markersize=4, label=state)
        axis.plot(frequency, falls, "k-", label="frame: falls")
        axis.axhline(math.tan(frame.alpha), color="k", linestyle="--", label="frame: moves")
        axis.set(
            title=f"friction {friction:g}", xlabel="frequency of the pulse, Hz", ylim=(0, 2.05)
        )
    axes[0].set_ylabel("amplitude, g")
    axes[0].legend(fontsize=7, loc="upper left")
    figure.tight_layout()
    figure.savefig(PICTURE, dpi=110)


def main() -> None:
    """Run all, write the table and draw the picture."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--points", type=int, default=16, help="frequencies, and amplitudes")
    found = list(rows(parser.parse_args().points))
    write_table(TABLE, found)
    draw(found)


if __name__ == "__main__":
    main()
