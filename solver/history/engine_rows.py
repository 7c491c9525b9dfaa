"""Rows of engines: where their parts begin, and the parts that all engines write alike.

They have the columns of all motions of the ground: those that a scene does not have are left out
when a row enters the history. What is written goes into one row, (columns,), or into several of
them, (columns, n), by arrays over these.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from geometry.block import Block
from solver.history.columns import (
    DISSIPATED_ENERGIES,
    STORED_ENERGIES,
    Structure,
    columns,
    positions,
    row_layout,
)
from solver.history.link_columns import LinkRows
from solver.scene.link import LinkSpec
from solver.types import Array

DIRECTIONS = ("", "_second")
"""Names of the horizontal directions within those of columns."""


class EngineRows:
    """The columns of the rows of an engine."""

    def __init__(
        self,
        shapes: Mapping[str, Block],
        links: Sequence[LinkSpec],
        *,
        dimension: int,
        platform: bool,
        structure: Structure | None = None,
    ):
        """Find their places.

        Args:
            shapes: The blocks by their names, in the order of their columns.
            links: Between bodies.
            dimension: Of space, d.
            platform: True if what carries the blocks moves as a whole.
            structure: What it has where it is meshed.
        """
        self.dimension = d = dimension
        feet = {name: shape.feet for name, shape in shapes.items()}
        self.names = columns(
            list(shapes),
            dimension=d,
            platform=platform,
            vertical=True,
            second=d == 3,
            structure=structure,
            links={link.name: not link.is_axial for link in links},
            feet=feet,
        )
        self.layout = row_layout(len(shapes), dimension=d, platform=platform)
        self.run = positions("run", d)
        """Places of the columns of the run."""
        self.links = LinkRows(links, self.names, d)
        """Writer of the columns of links."""
        first, stride = self.layout.block, self.layout.stride
        ends = range(first, first + stride * (len(shapes) + 1), stride)
        self.blocks = [slice(*both) for both in pairwise(ends)]
        """Places of the columns of each block."""
        self.feet = [self._feet_of(name, count) for name, count in feet.items()]
        """Columns of the feet, one after another: of each the normal force, then friction."""
        energies = (*STORED_ENERGIES, "input", *DISSIPATED_ENERGIES, "total", "ledger_error")
        at = positions("energy", d)
        self._energies = [self.layout.energy + getattr(at, f"{name}_J") for name in energies]

    def _feet_of(self, name: str, count: int) -> slice:
        """Places of the columns of the feet of a block."""
        first = self.names.index(f"{name}.foot_1.normal_force_N") if count else 0
        return slice(first, first + count * self.dimension)

    def write_run(self, row: Array, step: float, iterations: Any, closed: Any, base: Array) -> None:
        """Fill in length and iterations of a step, closed points, and the ground's acceleration.

        All columns of the run but the time; the acceleration is (d,), m/s2.
        """
        run = self.run
        row[run.step_s], row[run.newton_iterations] = step, iterations
        row[run.contact_points_closed] = closed
        row[run.base_acceleration_m_s2] = base[0]
        row[run.base_vertical_acceleration_m_s2] = base[-1]
        if self.dimension == 3:
            row[run.base_second_acceleration_m_s2] = base[1]

    def write_platform(self, row: Array, drift: Array, velocity: Array, gained: Array) -> None:
        """Fill in the motion of what carries the blocks along the horizontal directions.

        Drift (m), velocity (m/s) and mean acceleration of the step (m/s2), (d - 1,).
        """
        own, at = row[self.layout.platform :], positions("platform", self.dimension)
        for k, way in enumerate(DIRECTIONS[: self.dimension - 1]):
            own[getattr(at, f"drift{way}_m")] = drift[k]
            own[getattr(at, f"velocity{way}_m_s")] = velocity[k]
            own[getattr(at, f"acceleration{way}_m_s2")] = gained[k]

    def write_base_shear(self, row: Array, shear: Array) -> None:
        """Fill in the force on the ground along the horizontal directions, N, (d - 1,)."""
        own, at = row[self.layout.foundation :], positions("foundation", self.dimension)
        for k, way in enumerate(DIRECTIONS[: self.dimension - 1]):
            own[getattr(at, f"base_shear{way}_N")] = shear[k]

    def write_energies(
        self, row: Array, stored: Sequence[Any], exchanged: Sequence[Any], start: Any
    ) -> None:
        """Fill in all energies, J.

        Args:
            row: The row.
            stored: In the order of `STORED_ENERGIES`.
            exchanged: What was taken in, and lost by `DISSIPATED_ENERGIES`, since the start.
            start: What was stored then.
        """
        total, (taken, *lost) = sum(stored), exchanged
        error = total - taken + sum(lost) - start
        values = (*stored, taken, *lost, total, error)
        for place, value in zip(self._energies, values, strict=True):
            row[place] = value
