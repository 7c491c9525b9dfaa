"""A scene: what is to be simulated, in code and in TOML."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any, Literal

from solver.errors import SceneError, Statement, missing_key, not_applicable
from solver.scene.block import BlockSpec
from solver.scene.checking import (
    OPEN,
    Checked,
    is_open,
    nearest,
    shown,
    to_table,
)
from solver.scene.contact import Bed, ContactSpec, FrictionSpec
from solver.scene.damping import DampingSpec
from solver.scene.footing import refuse_beside
from solver.scene.foundation import FoundationSpec, FrameSpec, PlateSpec, Platform, RigidSpec
from solver.scene.limits import longest_step, refuse_beyond
from solver.scene.material import Plane
from solver.scene.motion import MotionSpec
from solver.scene.output import OutputSpec
from solver.scene.ranges import Dimension, NotNegative, Tilt
from solver.scene.time import TimeSpec

BED_OVER_BLOCK = 0.1
"""Stiffness of a bed over that of the block on it, (lambda + 2 mu)/H, unless it is given: the block
moves as a whole while it lands, and its losses are those of a mass on a spring and a dashpot."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene(Checked):
    """All of a simulation's input, checked; nothing is left open in its parts."""

    title: str = ""
    """Appears in `summary.json` and in `rockslip check`."""
    dimension: Dimension = 2
    """Dimension of space."""
    plane: Literal["strain", "stress"] = OPEN
    """Plane strain or plane stress of all meshed bodies; 2-D only. Default: `"strain"`; 3-D: -."""
    gravity: NotNegative = 9.81
    """g, m/s²."""
    gravity_tilt_deg: Tilt = 0.0
    """Turns gravity towards +x, degrees: an incline that falls towards +x. Axes and motions stay
    those of the ground: along the incline and across it."""
    blocks: tuple[BlockSpec, ...] = field(metadata={"key": "block"})
    """`[[block]]`, below."""
    foundation: FoundationSpec = field(default_factory=RigidSpec)
    """`[foundation]`, below. Default: the rigid ground."""
    contact: ContactSpec = field(default_factory=ContactSpec)
    """`[contact]`, below. Default: its defaults."""
    damping: DampingSpec | None = None
    """`[damping]`, below, of bodies that do not have their own. Default: elastic blocks have [2 %
    of critical](#default-damping), and meshed foundations none."""
    motion: MotionSpec | None = None
    """`[motion]`, below; the ground is still without it. Default: -."""
    time: TimeSpec
    """`[time]`, below."""
    output: OutputSpec = field(default_factory=OutputSpec)
    """`[output]`, below. Default: its defaults."""

    def __post_init__(self) -> None:
        """Check the values, and fill in what depends on the dimension."""
        Checked.__post_init__(self)
        if not self.blocks:
            raise SceneError("block", "0 blocks", "one block or more, [[block]]")
        self._check_names()
        order = self.order  # refuses circles
        if self.dimension == 2 and is_open(self.plane):
            object.__setattr__(self, "plane", "strain")
        if self.dimension == 3 and not is_open(self.plane):
            raise not_applicable("plane", "2-D scenes only")
        object.__setattr__(self, "blocks", tuple(self._filled(block) for block in self.blocks))
        self._check_thickness(order[0])
        try:
            foundation = self.foundation.in_dimension(self.dimension, self.blocks[0].thickness)
        except SceneError as error:
            raise error.under("foundation") from None
        object.__setattr__(self, "foundation", foundation)
        if self.dimension == 2 and self.motion is not None and self.motion.second is not None:
            raise not_applicable("motion.second", "3-D scenes only")
        for block in self.blocks:
            if block.restitution is not None and not self.is_rigid:
                allowed = "scenes in which nothing is meshed only"
                raise not_applicable(f"{block.name}.restitution", allowed)
        self._check_bed()
        object.__setattr__(self, "time", self._filled_time())
        refuse_beside(self)
        if next(self.strangers(), None) is not None:
            from solver.scene.overlaps import refuse_overlaps  # needs numpy, other scenes do not

            refuse_overlaps(self)
        refuse_beyond(self, self.known_shaking)
        self._fill_damping()
        if self.time.adaptive and self.is_rigid:
            # Their steps are cut where bodies touch and where slips end, whatever `step` is.
            raise not_applicable("time.adaptive", "scenes with meshed bodies only")

    def _check_names(self) -> None:
        """Every block has a name of its own and stands on something that is there."""
        names = [block.name for block in self.blocks]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise Statement("two blocks", f'are named "{twice}"; give each block a name of its own')
        for block in self.blocks:
            carriers = ["foundation", *(name for name in names if name != block.name)]
            if block.on not in carriers:
                allowed = " or ".join(map(shown, carriers))
                meant = nearest(block.on, carriers)
                raise SceneError(f"{block.name}.on", shown(block.on), allowed, meant)

    def _check_bed(self) -> None:
        """A bed belongs to scenes with a mesh, and its stiffness is known."""
        for key in ("stiffness", "damping"):
            if self.is_rigid and getattr(self.contact, key):
                what = "scenes with a meshed body only, block.restitution to rigid blocks"
                raise not_applicable(f"contact.{key}", what)
        rigid = next((block.name for block in self.blocks if block.model == "rigid"), None)
        if self.contact.damping and self.contact.stiffness is None and rigid is not None:
            what = f"beside contact.damping, since {rigid} is rigid (stiffness > 0, Pa/m)"
            raise missing_key("contact.stiffness", what)

    def _filled(self, block: BlockSpec) -> BlockSpec:
        """A block with nothing left open."""
        try:
            filled = block.in_dimension(self.dimension)
            tetrahedra = filled.model == "elastic" and filled.cell == "tetrahedron"
            if tetrahedra and filled.degree == 2 and self.contact.points == "nodes":
                # Their faces have no rule with positive weights at the vertices.
                allowed = '1 for tetrahedra, or contact.points = "gauss"'
                raise SceneError("degree", "2", allowed)
        except SceneError as error:
            raise error.under(block.name) from None
        return filled

    def _fill_damping(self) -> None:
        """Give elastic blocks the default damping, or its beta_R where only lambda_R is given.

        What `[damping]` leaves open they then have for themselves, and nobody else but a meshed
        foundation.
        """
        filled = tuple(self._damped(block) for block in self.blocks)
        given, before = self.damping, self.blocks
        object.__setattr__(self, "blocks", filled)
        if given is not None and is_open(given.stiffness):
            moved = filled != before and not self.foundation.is_meshed
            object.__setattr__(self, "damping", None if moved else given.closed(0.0))

    def _damped(self, block: BlockSpec) -> BlockSpec:
        """A block with nothing left open about its damping, if it is elastic."""
        given = block.damping or self.damping
        known = given is not None and not is_open(given.stiffness)
        if block.model != "elastic" or known:
            return block
        try:
            default = self.default_damping(block)
        except SceneError as error:  # beyond the range of numbers
            raise error.under(f"{block.name}.damping") from None
        return replace(block, damping=given.closed(default.stiffness) if given else default)

    def _filled_time(self) -> TimeSpec:
        """Time stepping with nothing left open."""
        fastest = max(block.shape.frequency(self.gravity) for block in self.blocks)
        spin = max(math.hypot(*block.spins) for block in self.blocks)
        try:
            return self.time.in_scene(
                is_rigid=self.is_rigid,
                frequency=fastest,
                spin=spin if self.dimension == 3 else 0.0,  # turns are exact in the plane
                period=min(
                    (motion.shortest_period for _, motion in self.motions), default=math.inf
                ),
                stiffest=longest_step(self),
            )
        except SceneError as error:
            raise error.under("time") from None

    def _check_thickness(self, first: BlockSpec) -> None:
        """In the plane all bodies are equally thick."""
        for block in self.blocks:
            if self.dimension == 2 and block.thickness != first.thickness:
                allowed = f"that of {first.name}, {first.thickness:g}, where dimension = 2"
                raise SceneError(f"{block.name}.thickness", shown(block.thickness), allowed)

    @property
    def gravity_vector(self) -> tuple[float, ...]:
        """Gravity along x and y (3-D: x, y and z), m/s^2."""
        tilt = math.radians(self.gravity_tilt_deg)
        along, down = self.gravity * math.sin(tilt), -self.gravity * math.cos(tilt)
        return (along, down) if self.dimension == 2 else (along, 0.0, down)

    @property
    def order(self) -> tuple[BlockSpec, ...]:
        """The blocks, each after what carries it, else as in the file."""
        placed: list[BlockSpec] = []
        waiting = list(self.blocks)
        while waiting:
            there = {"foundation", *(block.name for block in placed)}
            ready = [block for block in waiting if block.on in there]
            if not ready:
                circle = ", ".join(f"{block.name} on {block.on}" for block in waiting)
                raise SceneError(f"{waiting[0].name}.on", circle, "a stack that ends on foundation")
            placed += ready
            waiting = [block for block in waiting if block.on not in there]
        return tuple(placed)

    @property
    def motions(self) -> tuple[tuple[str, MotionSpec], ...]:
        """The motions of the ground that the scene asks for, each with the path of its table."""
        if self.motion is None:
            return ()
        beside = ((f"motion.{key}", motion) for key, motion in self.motion.beside())
        return (("motion", self.motion), *beside)

    @property
    def directions(self) -> tuple[str, ...]:
        """Paths of the tables of motions along x, in space y, and upwards."""
        second = ("motion.second",) if self.dimension == 3 else ()
        return ("motion", *second, "motion.vertical")

    @property
    def known_shaking(self) -> float:
        """Peaks of the ground's acceleration in all directions, added up, m/s2.

        Of those motions whose keys tell it.
        """
        return sum(motion.known_peak or 0.0 for _, motion in self.motions)

    @property
    def carried_mass(self) -> float:
        """Mass of all blocks, kg."""
        return sum(block.shape.mass for block in self.blocks)

    @property
    def is_rigid(self) -> bool:
        """Whether the engine of rigid blocks runs it: nothing is meshed.

        It does not know the ends of a plate that is held, but the law of impact with a restitution.
        """
        firm = self.foundation.is_firm and any(block.restitution for block in self.blocks)
        rigid = all(block.model == "rigid" for block in self.blocks)
        return rigid and (firm or not self.foundation.needs_mesh_engine)

    @property
    def has_platform(self) -> bool:
        """Whether the blocks stand on a spring: an oscillator, or a plate on rollers."""
        return self.foundation.on_spring

    @property
    def carrier_moves(self) -> bool:
        """Whether what carries the blocks moves as a whole: on a spring, or on columns."""
        return self.foundation.moves_as_a_whole

    @property
    def material_plane(self) -> Plane:
        """The state of stress in elastic bodies: plane strain, plane stress, or that of space."""
        return "solid" if self.dimension == 3 else self.plane

    def platform(self) -> Platform:
        """Mass, stiffness and damping of the empty platform; ValueError if there is none."""
        found = self.foundation.platform(self.carried_mass)
        if found is None:
            raise ValueError(f"a foundation of kind {self.foundation.kind} has no spring")
        return found

    def stacked_mass(self, block: BlockSpec) -> float:
        """Mass of a block and of all that stands on it, kg."""
        above = (other for other in self.blocks if other.on == block.name)
        return block.shape.mass + sum(self.stacked_mass(other) for other in above)

    def carrier_of(self, block: BlockSpec) -> BlockSpec | None:
        """The block that carries a block; None: the foundation does."""
        return next((carrier for carrier in self.blocks if carrier.name == block.on), None)

    def strangers(self) -> Iterator[tuple[BlockSpec, BlockSpec]]:
        """All pairs of blocks of which neither carries the other: they do not feel each other."""
        for first, second in combinations(self.blocks, 2):
            if first.on != second.name and second.on != first.name:
                yield first, second

    def damping_of(self, body: BlockSpec | PlateSpec | FrameSpec) -> DampingSpec | None:
        """Rayleigh damping of a meshed body: its own, or that of all."""
        given = body.damping or self.damping
        return None if given is None else given.closed(0.0)  # open: that of a foundation

    def bending_frequency(self, block: BlockSpec) -> float:
        """First natural frequency (rad/s) of an elastic block that is held at its base."""
        return min(block.bending_frequencies(self.material_plane))

    def default_damping(self, block: BlockSpec) -> DampingSpec:
        """Damping of an elastic block where nothing is said; ValueError for a rigid one."""
        return block.default_damping(self.material_plane, self.friction_of(block).static)

    @property
    def foundation_vibrates(self) -> bool:
        """Whether a meshed foundation has no damping of its strain, so that its vibration lasts."""
        foundation = self.foundation
        if not isinstance(foundation, PlateSpec | FrameSpec) or not foundation.is_meshed:
            return False
        own = self.damping_of(foundation)
        return not (foundation.sway_damping_ratio or (own and own.stiffness))

    @property
    def vibration_left(self) -> float:
        """The largest share of a block's bending vibration that is left after 1/p, p of rocking.

        By its first mode as a cantilever; 1 where a block is not damped, 0 where none is meshed.
        """
        left = 0.0
        for block in self.blocks:
            if block.model == "elastic" and self.gravity > 0.0:
                damping = self.damping_of(block) or DampingSpec()
                time = 1.0 / block.shape.frequency(self.gravity)
                left = max(left, damping.left(self.bending_frequency(block), time))
        return left

    def friction_of(self, block: BlockSpec) -> FrictionSpec:
        """Friction between a block and what carries it."""
        return FrictionSpec.of(self.contact.friction if block.friction is None else block.friction)

    def bed_of(self, block: BlockSpec) -> Bed | None:
        """The bed between a block and what carries it; None: there is none."""
        contact, mass = self.contact, block.shape.density * block.height
        if not contact.has_bed:
            return None
        stiffness = contact.stiffness
        if stiffness is None:
            own = block.material(self.material_plane).longitudinal / block.height
            stiffness = BED_OVER_BLOCK * own
        return Bed.damped(stiffness, contact.damping, mass)

    def to_dict(self) -> dict[str, Any]:
        """The scene as plain tables, every default written out."""
        return to_table(self)
