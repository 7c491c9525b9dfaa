"""The columns of a history: one table, which all engines fill by name.

A new column is one entry of `TABLE`, and a line in `solver.history.block_columns` where it follows
from a block's motion as a rigid body, else one in each engine. Names of the columns, their places
in a row and the tables of docs/output.md follow from the table.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from typing import Any, Literal, NamedTuple

import numpy as np

from solver.types import Array

Part = Literal["run", "block", "platform", "energy"]
"""The parts of a row, which lie one after the other; that of the blocks once for each block."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column, or one for each block where its name begins with `NAME.`."""

    name: str
    unit: str
    meaning: str
    dimension: Literal[2, 3] | None = None
    """The dimension of space in which it exists; None: both."""
    needs: Literal["", "vertical", "second", "platform"] = ""
    """The motion of the ground, or the platform, without which it does not exist."""
    energy: Literal["", "stored", "dissipated"] = ""
    """What kind of energy it is."""

    @property
    def part(self) -> Part:
        """The part of a row that it belongs to."""
        parts: dict[str, Part] = {"NAME": "block", "platform": "platform", "energy": "energy"}
        return parts.get(self.name.partition(".")[0], "run")

    @property
    def field(self) -> str:
        """Its name within its part, as an identifier."""
        own = self.name.partition(".")[2] if self.part != "run" else self.name
        return own.replace(".", "_")


TABLE = (
    Column("time_s", "s", "Time at the end of the step."),
    Column("step_s", "s", "Length of the step."),
    Column("newton_iterations", "-", "Iterations of the nonlinear solver in the step."),
    Column("contact_points_closed", "-", "Number of contact points with a normal force."),
    Column(
        "base.acceleration_m_s2",
        "m/s²",
        "Acceleration of the ground along x; a positive one accelerates the ground towards +x.",
    ),
    Column(
        "base.vertical_acceleration_m_s2",
        "m/s²",
        "Vertical acceleration of the ground, positive upwards; only with `[motion.vertical]`.",
        needs="vertical",
    ),
    Column(
        "base.second_acceleration_m_s2",
        "m/s²",
        "Acceleration of the ground along y; only with `[motion.second]`.",
        dimension=3,
        needs="second",
    ),
    Column("NAME.angle_rad", "rad", "Best-fit rigid rotation (mass-weighted).", 2),
    Column(
        "NAME.angular_velocity_rad_s",
        "rad/s",
        "Moment of momentum about the centre of mass over the rotary inertia.",
        2,
    ),
    Column(
        "NAME.angle_rad",
        "rad",
        "Lean in the plane of motion: the angle about +y by which the block's upright axis leans"
        " towards +x, not wrapped.",
        3,
    ),
    Column("NAME.angle_x_rad", "rad", "Best-fit rigid rotation as a rotation vector: about x.", 3),
    Column("NAME.angle_y_rad", "rad", "The rotation vector about y.", 3),
    Column("NAME.angle_z_rad", "rad", "The rotation vector about z.", 3),
    Column("NAME.angular_velocity_x_rad_s", "rad/s", "Angular velocity about the ground's x.", 3),
    Column("NAME.angular_velocity_y_rad_s", "rad/s", "Angular velocity about the ground's y.", 3),
    Column("NAME.angular_velocity_z_rad_s", "rad/s", "Angular velocity about the ground's z.", 3),
    Column(
        "NAME.slip_m",
        "m",
        "Mean displacement of the touching points along x of the carrier and relative to it, or"
        " that of the lowest point where none touches; 0 at the start, carried on from pivot to"
        " pivot.",
    ),
    Column("NAME.slip_second_m", "m", "Slip along y of the carrier, as along x.", 3),
    Column(
        "NAME.gap_left_m",
        "m",
        "Height of the block's own bottom left corner over the plane of its carrier's top, or over"
        " level 0 once the block's centre has fallen below that plane.",
        2,
    ),
    Column("NAME.gap_right_m", "m", "Height of the bottom right corner, measured likewise.", 2),
    Column(
        "NAME.gap_1_m",
        "m",
        "Height of the bottom corner at (-x, -y) of the block's own axes over the plane of its"
        " carrier's top, or over level 0 once the block's centre has fallen below that plane.",
        3,
    ),
    Column("NAME.gap_2_m", "m", "Height of the corner at (+x, -y), measured likewise.", 3),
    Column("NAME.gap_3_m", "m", "Height of the corner at (+x, +y), measured likewise.", 3),
    Column("NAME.gap_4_m", "m", "Height of the corner at (-x, +y), measured likewise.", 3),
    Column(
        "NAME.penetration_m",
        "m",
        "Largest depth of a contact point of the block in what carries it or lies below it, or of a"
        " point of that in the block (edges included); 0 where there is none.",
    ),
    Column("NAME.centre_x_m", "m", "Centre of mass along x."),
    Column("NAME.centre_y_m", "m", "Centre of mass along y."),
    Column("NAME.centre_z_m", "m", "Centre of mass along z.", 3),
    Column(
        "NAME.normal_force_N",
        "N",
        "Contact force on the block normal to its carrier, positive when it presses the block away;"
        " the upward force once the carrier is lost, as for the gaps.",
    ),
    Column(
        "NAME.friction_force_N",
        "N",
        "Contact force on the block along its carrier, positive towards +x.",
    ),
    Column(
        "NAME.friction_force_second_N",
        "N",
        "Contact force on the block along its carrier, positive towards +y.",
        3,
    ),
    Column(
        "platform.drift_m",
        "m",
        "Displacement along x relative to the ground; of a meshed platform the mean of its top.",
        needs="platform",
    ),
    Column("platform.velocity_m_s", "m/s", "Rate of this drift.", needs="platform"),
    Column(
        "platform.acceleration_m_s2",
        "m/s²",
        "Acceleration along x relative to the ground, the mean of the step.",
        needs="platform",
    ),
    Column(
        "platform.drift_second_m",
        "m",
        "Displacement along y relative to the ground.",
        3,
        "platform",
    ),
    Column("platform.velocity_second_m_s", "m/s", "Rate of this drift.", 3, "platform"),
    Column(
        "platform.acceleration_second_m_s2",
        "m/s²",
        "Acceleration along y relative to the ground, the mean of the step.",
        3,
        "platform",
    ),
    Column("energy.kinetic_J", "J", "Kinetic energy, relative to the ground.", energy="stored"),
    Column("energy.strain_J", "J", "Strain energy of the meshed bodies.", energy="stored"),
    Column(
        "energy.gravity_J",
        "J",
        "Potential energy of gravity, 0 at level 0; on an incline 0 at the origin.",
        energy="stored",
    ),
    Column("energy.spring_J", "J", "Energy in the spring of the platform.", energy="stored"),
    Column(
        "energy.interface_J",
        "J",
        "Energy of Nitsche's contact terms, which may be negative, and of the bed.",
        energy="stored",
    ),
    Column("energy.input_J", "J", "Work of the moving ground since the start."),
    Column("energy.friction_J", "J", "Dissipated by friction.", energy="dissipated"),
    Column(
        "energy.damping_J",
        "J",
        "Dissipated by material damping and the dashpot of the platform.",
        energy="dissipated",
    ),
    Column(
        "energy.contact_damping_J",
        "J",
        "Dissipated by the dashpots of beds.",
        energy="dissipated",
    ),
    Column(
        "energy.contact_J",
        "J",
        "Dissipated by impacts and by the velocity solve.",
        energy="dissipated",
    ),
    Column("energy.numerical_J", "J", "Dissipated by time integration.", energy="dissipated"),
    Column("energy.total_J", "J", "Sum of the stored energies."),
    Column(
        "energy.ledger_error_J",
        "J",
        "Total minus total at the start minus input plus the dissipated energies.",
    ),
)


def _energies(kind: str) -> tuple[str, ...]:
    """Names of the energies of a kind, such as "kinetic"."""
    return tuple(column.field.removesuffix("_J") for column in TABLE if column.energy == kind)


STORED_ENERGIES = _energies("stored")
"""Their sum is `energy.total_J`."""

DISSIPATED_ENERGIES = _energies("dissipated")
"""What has been dissipated since the start, each from its own formula."""


def columns(
    blocks: Sequence[str],
    *,
    dimension: int = 2,
    platform: bool = False,
    vertical: bool = False,
    second: bool = False,
) -> tuple[str, ...]:
    """Names of all columns of the history of a scene, in their order, by the names of its blocks.

    `platform`: whether what carries the blocks moves as a whole; `vertical`, `second`: whether the
    ground also moves up and down, or along the second horizontal direction.
    """
    exists = {"": True, "platform": platform, "vertical": vertical, "second": second}
    there = [c for c in TABLE if c.dimension in (None, dimension) and exists[c.needs]]
    names: list[str] = []
    for part, group in groupby(there, key=lambda column: column.part):
        own = [column.name for column in group]
        for name in blocks if part == "block" else [""]:
            names += [column.replace("NAME", name) for column in own]
    return tuple(names)


@cache
def positions(part: Part, dimension: int) -> Any:
    """Places of the columns of a part of a row within that part, as a named tuple of integers.

    `positions("block", 2).angle_rad` is a place within the part of a block in the plane. The
    engines' rows have the columns of all motions of the ground: those that a scene does not have
    are left out when a row enters the history. Compiled code takes the tuple as a constant.
    """
    fields = [c.field for c in TABLE if c.part == part and c.dimension in (None, dimension)]
    return namedtuple(f"{part.title()}Columns", fields)(*range(len(fields)))


class RowLayout(NamedTuple):
    """Where the parts of an engine's row begin: that of the run at 0."""

    block: int
    """The part of the first block."""
    stride: int
    """Number of columns of a block."""
    platform: int
    energy: int


def row_layout(blocks: int, *, dimension: int, platform: bool) -> RowLayout:
    """Where the parts of a row with all motions of the ground begin, for a number of blocks.

    `platform`: whether what carries the blocks moves as a whole.
    """
    first, stride = len(positions("run", dimension)), len(positions("block", dimension))
    after = first + blocks * stride
    moving = len(positions("platform", dimension)) if platform else 0
    return RowLayout(first, stride, after, after + moving)


def check_filled(names: Sequence[str], rows: Array) -> None:
    """Make sure that an engine has filled all columns of the rows that it began as nan.

    Raises:
        ValueError: Names the columns that are nan in every row.
    """
    empty = [names[k] for k in np.flatnonzero(np.isnan(rows).all(axis=0))] if len(rows) else []
    if empty:
        raise ValueError(f"no value for the columns {', '.join(empty)}")
