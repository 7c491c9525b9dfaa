"""The table of all columns of histories, which all engines fill by name.

A new column is one entry of `TABLE`, and a line in `solver.history.block_columns` where it follows
from a block's motion as a rigid body, else one in each engine. Names of the columns, their order
and the tables of docs/output.md follow from the table.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Part = Literal[
    "run", "block", "platform", "energy", "foundation", "storey", "column", "link", "foot"
]
"""The parts of a row, which lie one after the other; those of blocks, storeys and columns of a
frame, links, and feet of blocks once for each of them."""

PARTS: dict[str, Part] = {
    "NAME": "block",
    "platform": "platform",
    "energy": "energy",
    "foundation": "foundation",
    "STOREY": "storey",
    "COLUMN": "column",
    "LINK": "link",
    "FOOT": "foot",
}
"""The parts by the first word of the names of their columns."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column; of one of several blocks, storeys and so on where it begins with a capital word."""

    name: str
    unit: str
    meaning: str
    dimension: Literal[2, 3] | None = None
    """The dimension of space in which it exists; None: both."""
    needs: Literal["", "vertical", "second", "structure", "axes"] = ""
    """The motion of the ground, the mesh of a platform, or the axes of a link, without which it
    does not exist."""

    @property
    def part(self) -> Part:
        """The part of a row that it belongs to."""
        return PARTS.get(self.name.partition(".")[0], "run")


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
        " pivot and through flights: summaries call it displacement, and slip what is not flown.",
    ),
    Column("NAME.slip_second_m", "m", "Slip along y of the carrier, as along x.", 3),
    Column(
        "NAME.gap_left_m",
        "m",
        "Height of the block's own bottom left corner over the plane of its carrier's top, or over"
        " level 0 once the carrier is lost.",
        2,
    ),
    Column("NAME.gap_right_m", "m", "Height of the bottom right corner, measured likewise.", 2),
    Column(
        "NAME.gap_1_m",
        "m",
        "Height of the bottom corner at (-x, -y) of the block's own axes over the plane of its"
        " carrier's top, or over level 0 once the carrier is lost.",
        3,
    ),
    Column("NAME.gap_2_m", "m", "Height of the corner at (+x, -y), measured likewise.", 3),
    Column("NAME.gap_3_m", "m", "Height of the corner at (+x, +y), measured likewise.", 3),
    Column("NAME.gap_4_m", "m", "Height of the corner at (-x, +y), measured likewise.", 3),
    Column(
        "NAME.penetration_m",
        "m",
        "Largest depth of a contact point of the block in what carries it, lies below it or stands"
        " beside it, or of a point of that in the block (edges included); 0 where there is none.",
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
    ),
    Column("platform.velocity_m_s", "m/s", "Rate of this drift."),
    Column(
        "platform.acceleration_m_s2",
        "m/s²",
        "Acceleration along x relative to the ground, the mean of the step. After impacts on a"
        " meshed foundation it may swing from row to row: take means over some, or floor spectra.",
    ),
    Column("platform.drift_second_m", "m", "Displacement along y relative to the ground.", 3),
    Column("platform.velocity_second_m_s", "m/s", "Rate of this drift.", 3),
    Column(
        "platform.acceleration_second_m_s2",
        "m/s²",
        "Acceleration along y relative to the ground, the mean of the step.",
        3,
    ),
    Column("energy.kinetic_J", "J", "Kinetic energy, relative to the ground."),
    Column("energy.strain_J", "J", "Strain energy of the meshed bodies."),
    Column(
        "energy.gravity_J",
        "J",
        "Potential energy of gravity, 0 at level 0, of plates and frames 0 where they are not"
        " deformed; on an incline 0 at the origin.",
    ),
    Column("energy.spring_J", "J", "Energy in links and a platform's spring."),
    Column(
        "energy.interface_J",
        "J",
        "Energy of Nitsche's contact terms, which may be negative, and of the bed.",
    ),
    Column("energy.input_J", "J", "Work of the moving ground, and of forces, since the start."),
    Column("energy.friction_J", "J", "Dissipated by friction."),
    Column(
        "energy.damping_J",
        "J",
        "Dissipated by material damping and the dashpot of the platform; by dashpots, flow and"
        " fracture of links.",
    ),
    Column("energy.contact_damping_J", "J", "Dissipated by the dashpots of beds."),
    Column("energy.contact_J", "J", "Dissipated by impacts and by the velocity solve."),
    Column("energy.numerical_J", "J", "Dissipated by time integration."),
    Column("energy.total_J", "J", "Sum of the stored energies."),
    Column(
        "energy.ledger_error_J",
        "J",
        "Total minus total at the start minus input plus the dissipated energies.",
    ),
    Column(
        "foundation.base_shear_N",
        "N",
        "Force of the platform or structure on the ground along x, the mean of the step: less the"
        " sum of all masses times their absolute accelerations, plus all `[[force]]`.",
    ),
    Column("foundation.base_shear_second_N", "N", "That along y.", 3),
    Column(
        "foundation.overturning_moment_Nm",
        "N m",
        "Moment on the ground about the centre of the base, positive when it presses down the"
        " side at +x.",
        needs="structure",
    ),
    Column(
        "foundation.overturning_moment_second_Nm",
        "N m",
        "That about x, positive when it presses down the side at +y.",
        3,
        needs="structure",
    ),
    Column(
        "STOREY.drift_m",
        "m",
        "Displacement along x of the storey's deck relative to the deck below, or to the"
        " ground; means of their tops.",
    ),
    Column("STOREY.drift_second_m", "m", "That along y.", 3),
    Column(
        "STOREY.velocity_m_s",
        "m/s",
        "Velocity of the storey's deck along x relative to the ground.",
    ),
    Column("STOREY.velocity_second_m_s", "m/s", "That along y.", 3),
    Column("COLUMN.shear_N", "N", "Force of the column's foot on the ground along x."),
    Column("COLUMN.shear_second_N", "N", "That along y.", 3),
    Column(
        "COLUMN.axial_force_N", "N", "Force of the foot on the ground downwards, which is pressure."
    ),
    Column(
        "COLUMN.moment_Nm",
        "N m",
        "Moment of the foot on the ground about the foot's centre, positive when it presses"
        " down the side at +x.",
    ),
    Column(
        "COLUMN.moment_second_Nm",
        "N m",
        "That about x, positive when it presses down the side at +y.",
        3,
    ),
    Column(
        "LINK.force_N",
        "N",
        "Tension, the mean of the step; of a link along axes the part along the vertical one,"
        " positive where it draws the two bodies together.",
    ),
    Column(
        "LINK.shear_force_N",
        "N",
        "Force of a link along axes on its first body along x of that, the mean of the step.",
        needs="axes",
    ),
    Column("LINK.shear_force_second_N", "N", "That along y.", 3, needs="axes"),
    Column(
        "LINK.extension_m",
        "m",
        "By how much it is longer than its length without stretch; of a link along axes that along"
        " the vertical one, positive where the bodies part; once it is broken by how much its ends"
        " are farther apart, in the step in which it breaks as it was at that instant.",
    ),
    Column("LINK.state", "-", "0: slack, 1: taut, 2: has flowed, 3: broken."),
    Column(
        "FOOT.normal_force_N",
        "N",
        "Force on the foot, the mean of the step, in the frame of its block's columns of forces:"
        " what carries the block, or level.",
    ),
    Column("FOOT.friction_force_N", "N", "That along x."),
    Column("FOOT.friction_force_second_N", "N", "That along y.", 3),
)
