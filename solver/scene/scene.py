"""A scene: all input of a simulation, resolved and checked; in code and in TOML."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any, Literal

from solver.errors import SceneError, Statement, below, missing_key, not_applicable
from solver.scene import limits
from solver.scene.block import BlockSpec
from solver.scene.checking import (
    OPEN,
    Checked,
    is_open,
    nearest,
    only_where,
    refuse_other_dimension,
    shown,
    to_table,
)
from solver.scene.contact import Bed, ContactSpec, FrictionSpec, PairSpec
from solver.scene.damping import DampingSpec
from solver.scene.force import ForceSpec
from solver.scene.foundation import FoundationSpec, FrameSpec, PlateSpec, Platform, RigidSpec
from solver.scene.laws import Law, Laws
from solver.scene.link import LinkSpec
from solver.scene.material import Plane
from solver.scene.motion import MotionSpec
from solver.scene.output import OutputSpec
from solver.scene.quantities import Dimension, Gravity, Tilt
from solver.scene.time import TimeSpec

if TYPE_CHECKING:
    from geometry.arrangement import Pose

ROUND_OFF = 1e-9
"""Edges that miss one another by less than this part of a length touch."""

BED_OVER_BLOCK = 0.1
"""Stiffness of a bed over that of the block on it, (lambda + 2 mu)/H, unless it is given: the block
moves as a whole while it lands, and its losses are those of a mass on a spring and a dashpot."""

RIGID = 'model = "rigid" for every block, no meshed foundation'
"""The remedy where the engine of meshed bodies cannot do what a key says."""

UNMESHED = f"scenes in which nothing is meshed only: {RIGID}"
"""The scenes to which restitutions and feet apply."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene(Checked):
    """All input of a simulation, checked; nothing is left open in its parts."""

    title: str = ""
    """Appears in `summary.json` and in `rockslip check`."""
    dimension: Dimension = 2
    """Dimension of space."""
    plane: Literal["strain", "stress"] = OPEN
    """Plane strain or plane stress of all meshed bodies; 2-D only. Default: `"strain"`; 3-D: -."""
    gravity: Gravity = 9.81
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
    pairs: tuple[PairSpec, ...] = field(default=(), metadata={"key": "pair"})
    """`[[pair]]`, below. Default: none."""
    links: tuple[LinkSpec, ...] = field(default=(), metadata={"key": "link"})
    """`[[link]]`, below. Default: none."""
    forces: tuple[ForceSpec, ...] = field(default=(), metadata={"key": "force"})
    """`[[force]]`, below. Default: none."""
    damping: DampingSpec | None = None
    """`[damping]`, below, of bodies that do not have their own. Default: elastic blocks have [2 %
    of critical](#default-damping), and meshed foundations none."""
    motion: MotionSpec | None = None
    """`[motion]`, below; the ground is still without it. Default: -."""
    time: TimeSpec
    """`[time]`, below."""
    output: OutputSpec = field(default_factory=OutputSpec)
    """`[output]`, below. Default: its defaults."""

    def resolved(self) -> Iterator[tuple[str, Any]]:
        """The fields that depend on the dimension, on other tables, and on the sizes of blocks."""
        self._check_names()
        refuse_other_dimension(self, self.dimension)
        if self.dimension == 2 and is_open(self.plane):
            yield "plane", "strain"
        yield "blocks", self._each_block(lambda block: block.in_dimension(self.dimension))
        thickness = self._thickness()
        with below("foundation"):
            foundation = self.foundation.in_dimension(self.dimension, thickness)
        yield "foundation", foundation
        with below("time"):
            time = self._resolved_time()
        yield "time", time
        given, before = self.damping, self.blocks
        yield "blocks", self._each_block(self._damped)
        if given is not None and is_open(given.stiffness):
            # Elastic blocks have what was open for themselves; it is left to a meshed foundation.
            moved = self.blocks != before and not self.foundation.is_meshed
            yield "damping", None if moved else given.closed(0.0)

    def check(self) -> None:
        """Refuse tables that do not go together, and scenes beyond the limits of the method."""
        only_where(self, self.dimension == 2, "2-D scenes only", "plane")
        if self.dimension == 2 and self.motion is not None and self.motion.second is not None:
            raise not_applicable("motion.second", "3-D scenes only")
        self._check_engine()
        for block in self.blocks:
            self._check_degree(block)
            self._check_place(block)
        if len(self.blocks) > 1 or self.blocks[0].position is not None:
            from solver.scene.places import refuse_places  # needs numpy, other scenes do not

            refuse_places(self.order, self.dimension, self.foundation.top)
        if self.links:
            from solver.scene.places import refuse_links

            refuse_links(self.links, self.poses(), self.dimension)
            limits.refuse_stiff_links(self.links, self.blocks, self.gravity)
        if (self.links or self.forces) and not self.is_rigid:
            from solver.scene.places import refuse_outside

            deck = self.foundation.top if self.foundation.is_meshed else None
            refuse_outside(self.links, self.forces, self.blocks, deck)
        self.check_limits(shaking=0.0)

    def _each_block(self, change: Callable[[BlockSpec], BlockSpec]) -> tuple[BlockSpec, ...]:
        """The blocks, each changed; errors are those of the block."""
        changed = []
        for block in self.blocks:
            with below(block.name):
                changed.append(change(block))
        return tuple(changed)

    def _check_names(self) -> None:
        """Every block has a name of its own and stands on something that is there."""
        names = [block.name for block in self.blocks]
        if not names:
            raise SceneError("block", "0 blocks", "one block or more, [[block]]")
        self._check_unique()
        for block in self.blocks:
            carriers = ["foundation", *(name for name in names if name != block.name)]
            for name in block.carriers:
                _refuse_unknown(f"{block.name}.on", name, carriers)
        self._check_pairs(["foundation", *names])
        self._check_joined(names)

    def _check_unique(self) -> None:
        """No two of blocks, links and forces have one name."""
        seen: dict[str, str] = {}
        kinds = (("block", self.blocks), ("link", self.links), ("force", self.forces))
        for kind, name in ((kind, member.name) for kind, all_ in kinds for member in all_):
            if name in seen:
                both = f"two {kind}s" if seen[name] == kind else f"a {seen[name]} and a {kind}"
                raise Statement(both, f'are named "{name}"; give each {kind} a name of its own')
            seen[name] = kind

    def _check_pairs(self, names: Sequence[str]) -> None:
        """Every pair is of two bodies that are there, and stands there once."""
        seen = set()
        for pair in self.pairs:
            for name in pair.between:
                _refuse_unknown(f"{pair.where}.between", name, names)
            if frozenset(pair.between) in seen:
                raise Statement(pair.where, "is there twice; give each pair one table")
            seen.add(frozenset(pair.between))

    def _check_joined(self, names: Sequence[str]) -> None:
        """Every link and every force is on bodies that are there, in this dimension."""
        for link in self.links:
            with below(link.name):
                for name in link.between:
                    _refuse_unknown("between", name, ["foundation", *names])
        for force in self.forces:
            with below(force.name):
                _refuse_unknown("on", force.on, names)
                force.refuse_elsewhere(self.dimension)
                pressed = next(block for block in self.blocks if block.name == force.on)
                if force.pressure is not None and pressed.given_shape is not None:
                    raise not_applicable("pressure", f"boxes; {force.on} has a shape: give force")

    def _thickness(self) -> float:
        """Thickness of the lowest block, m; in the plane all bodies are equally thick."""
        first = self.order[0]
        for block in self.blocks:
            if self.dimension == 2 and block.thickness != first.thickness:
                allowed = f"that of {first.name}, {first.thickness:g}, where dimension = 2"
                raise SceneError(f"{block.name}.thickness", shown(block.thickness), allowed)
        return first.thickness

    def _resolved_time(self) -> TimeSpec:
        """Time stepping with nothing left open."""
        fastest = max(block.shape.fastest(self.gravity) for block in self.blocks)
        spin = max(math.hypot(*block.spins) for block in self.blocks)
        periods = (motion.shortest_period for _, motion in self.motions)
        return self.time.in_scene(
            is_rigid=self.is_rigid,
            frequency=fastest,
            spin=spin if self.dimension == 3 else 0.0,  # turns are exact in the plane
            period=min(periods, default=math.inf),
            links=min(map(self.link_period, self.links), default=math.inf),
            stiffest=min((body.longest_step for body in self._turning_bodies()), default=math.inf),
        )

    def _damped(self, block: BlockSpec) -> BlockSpec:
        """A block with the default damping if it is elastic, or with its beta_R where open."""
        given = block.damping or self.damping
        if block.model != "elastic" or (given is not None and not is_open(given.stiffness)):
            return block
        with below("damping"):  # beyond the range of numbers
            default = self.default_damping(block)
        return replace(block, damping=given.closed(default.stiffness) if given else default)

    def _check_engine(self) -> None:
        """Refuse keys of meshed scenes where nothing is meshed, and the other way round."""
        rigid = next((block.name for block in self.blocks if block.model == "rigid"), None)
        if not self.is_rigid:
            for where, _ in self._restitutions():  # a meshed body rebounds by itself
                raise not_applicable(f"{where}.restitution", UNMESHED)
        for key in ("stiffness", "damping"):
            if self.is_rigid and getattr(self.contact, key):
                what = "scenes with a meshed body only, block.restitution to rigid blocks"
                raise not_applicable(f"contact.{key}", what)
        if self.contact.damping and self.contact.stiffness is None and rigid is not None:
            what = f"beside contact.damping, since {rigid} is rigid (stiffness > 0, Pa/m)"
            raise missing_key("contact.stiffness", what)
        if self.time.adaptive and self.is_rigid:
            # Their steps are cut where bodies touch and where slips end, whatever `step` is.
            raise not_applicable("time.adaptive", "scenes with meshed bodies only")

    def _check_degree(self, block: BlockSpec) -> None:
        """Refuse quadratic tetrahedra with nodes: no rule has positive weights at the vertices."""
        tetrahedra = block.model == "elastic" and block.mesh.kind == "tetrahedron"
        if tetrahedra and block.degree == 2 and self.contact.points == "nodes":
            allowed = '1 for tetrahedra, or contact.points = "gauss"'
            raise SceneError(f"{block.name}.degree", "2", allowed)

    def _check_place(self, block: BlockSpec) -> None:
        """Refuse a block of which nothing is above the one that carries it at the start."""
        if block.position is not None or len(block.carriers) > 1:
            return
        carrier = self.carrier_of(block)
        top = self.foundation.top if carrier is None else (carrier.width, carrier.thickness)
        if top is None:
            return
        found = [("offset", block.offset, block.width + top[0])]
        if self.dimension == 3:
            found.append(("offset_second", block.offset_second, block.thickness + top[1]))
        for key, offset, widths in found:
            reach = widths / 2
            if abs(offset) > reach * (1 + ROUND_OFF):
                allowed = (
                    f"between {-reach:g} and {reach:g}, so that {block.carrier} is below its bottom"
                )
                raise SceneError(f"{block.name}.{key}", shown(offset), allowed)

    def check_limits(self, shaking: float) -> None:
        """Refuse bodies too soft for what they carry or too stiff for the steps, and the like.

        Checked without the motion of the ground when a scene is made, and again when that has been
        read.

        Args:
            shaking: Peaks of the ground's acceleration in all directions, added up, m/s2.

        Raises:
            SceneError: Names the key, its value, and what is allowed.
        """
        limits.refuse_strong(shaking)
        contact, plane = self.contact, self.material_plane
        if not self.is_rigid and contact.theta != 1 and contact.points == "gauss":
            # At Gauss points theta = 0 and -1 give cohesion no energy: it gains without end.
            if any(self.friction_of(block).cohesion > 0 for block in self.blocks):
                got = f'{contact.theta} with points = "gauss" and cohesion'
                raise SceneError("contact.theta", got, '1, or points = "nodes"')
        for block in self.blocks:
            if block.model == "elastic":
                limits.refuse_long(block)
        for turning in self._turning_bodies():
            turning.refuse_stiff(self.time.largest or self.time.step)
        below_all = self.foundation.pressed_material(plane, self.carried_mass)
        masses = self.stacked_masses
        for block in self.blocks:
            weight = masses[block.name] * (self.gravity + shaking)
            pressure, bed = weight / block.shape.bottom_area, self.bed_of(block)
            if bed is not None:
                limits.refuse_soft_bed(block, contact, bed, pressure)
            carrier = self.carrier_of(block)
            for body in (block, carrier):
                if body is not None and body.model == "elastic":
                    limits.refuse_soft(f"{body.name}.young", body.material(plane), pressure)
            if block.model == "elastic":
                material = block.material(plane)
                limits.refuse_soft_corner(block, material, pressure)
                limits.refuse_without_energy(block, material, contact, pressure)
            if carrier is None and below_all is not None:
                limits.refuse_soft("foundation.young", below_all, pressure)

    def _turning_bodies(self) -> Iterator[limits.TurningBody]:
        """The meshed bodies that may turn."""
        plane = self.material_plane
        for block in self.blocks:
            if block.model == "elastic":
                yield limits.TurningBody.of(block, block.material(plane))
        turning = self.foundation.turning_cells(plane, self.carried_mass)
        if turning is not None:
            material, edge = turning
            yield limits.TurningBody(where="foundation.young", material=material, edge=edge)

    @property
    def gravity_vector(self) -> tuple[float, ...]:
        """Gravity along x and y (3-D: x, y and z), m/s^2."""
        tilt = math.radians(self.gravity_tilt_deg)
        along, down = self.gravity * math.sin(tilt), -self.gravity * math.cos(tilt)
        return (along, down) if self.dimension == 2 else (along, 0.0, down)

    @property
    def order(self) -> tuple[BlockSpec, ...]:
        """The blocks, each after all that carry it, else as in the file."""
        placed: list[BlockSpec] = []
        waiting = list(self.blocks)
        while waiting:
            there = {"foundation", *(block.name for block in placed)}
            ready = [block for block in waiting if there.issuperset(block.carriers)]
            if not ready:
                circle = ", ".join(f"{b.name} on {' and '.join(b.carriers)}" for b in waiting)
                raise SceneError(f"{waiting[0].name}.on", circle, "a stack that ends on foundation")
            placed += ready
            waiting = [block for block in waiting if not there.issuperset(block.carriers)]
        return tuple(placed)

    @property
    def motions(self) -> tuple[tuple[str, MotionSpec], ...]:
        """The motions of the ground, each with the path of its table."""
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
    def carried_mass(self) -> float:
        """Mass of all blocks, kg."""
        return sum(block.shape.mass for block in self.blocks)

    @property
    def is_rigid(self) -> bool:
        """True if the engine of rigid blocks runs it: nothing is meshed.

        That engine has no ends of a plate that is held, but the law of impact with a restitution.
        """
        firm = self.foundation.is_firm and any(e > 0 for _, e in self._restitutions())
        rigid = all(block.model == "rigid" for block in self.blocks)
        return rigid and (firm or not self.foundation.needs_mesh_engine)

    def _restitutions(self) -> Iterator[tuple[str, float]]:
        """Restitutions that are given, each with the path of its table."""
        for block in self.blocks:
            if block.restitution is not None:
                yield block.name, block.restitution
        for pair in self.pairs:
            if pair.restitution is not None:
                yield pair.where, pair.restitution

    @property
    def has_platform(self) -> bool:
        """True if the blocks stand on a spring: an oscillator, or a plate on rollers."""
        return self.foundation.on_spring

    @property
    def carrier_moves(self) -> bool:
        """True if what carries the blocks moves as a whole: on a spring, or on columns."""
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

    @property
    def stacked_masses(self) -> dict[str, float]:
        """Mass of each block and of all that stands on it, kg, by its name.

        Several carriers of a block have equal shares of it.
        """
        found = {block.name: block.shape.mass for block in self.blocks}
        for block in reversed(self.order):
            for name in found.keys() & set(block.carriers):
                found[name] += found[block.name] / len(block.carriers)
        return found

    def stacked_mass(self, block: BlockSpec) -> float:
        """Mass of a block and of all that stands on it, kg."""
        return self.stacked_masses[block.name]

    def carrier_of(self, block: BlockSpec) -> BlockSpec | None:
        """The block that carries a block, of several the first; None: the foundation does."""
        return next((carrier for carrier in self.blocks if carrier.name == block.carrier), None)

    def carriers_of(self, block: BlockSpec) -> tuple[BlockSpec, ...]:
        """The blocks that carry a block; none: the foundation does."""
        return tuple(carrier for carrier in self.blocks if carrier.name in block.carriers)

    def non_adjacent(self) -> Iterator[tuple[BlockSpec, BlockSpec]]:
        """All pairs of blocks of which neither carries the other at the start."""
        for first, second in combinations(self.blocks, 2):
            if first.is_beside(second):
                yield first, second

    def damping_of(self, body: BlockSpec | PlateSpec | FrameSpec) -> DampingSpec | None:
        """Rayleigh damping of a meshed body: its own, or that of all."""
        given = body.damping or self.damping
        return None if given is None else given.closed(0.0)  # open: that of a foundation

    def bending_frequency(self, block: BlockSpec) -> float:
        """First natural frequency (rad/s) of an elastic block that is held at its base."""
        return min(block.bending_frequencies(self.material_plane))

    def default_damping(self, block: BlockSpec) -> DampingSpec:
        """Damping of an elastic block by default; ValueError for a rigid one."""
        return block.default_damping(self.material_plane, self.friction_of(block).static)

    @property
    def foundation_vibrates(self) -> bool:
        """True if a meshed foundation has no damping of its strain, so that its vibration lasts."""
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

    def link_period(self, link: LinkSpec) -> float:
        """Natural period of the bodies of a link on its spring alone, s; the foundation is held."""
        masses = [block.shape.mass for block in self.blocks if block.name in link.between]
        stiffness = max(link.stiffness, link.shear_stiffness or 0.0)
        return 2 * math.pi / math.sqrt(stiffness * sum(1 / mass for mass in masses))

    @property
    def laws(self) -> Laws:
        """Laws of contact of any two bodies."""
        return Laws(self.blocks, self.pairs, self.contact.friction)

    def law_between(self, first: str, second: str) -> Law:
        """Friction and restitution of two bodies; for many pairs `laws.between`, which is this."""
        return self.laws.between(first, second)

    def friction_of(self, block: BlockSpec) -> FrictionSpec:
        """Friction between a block and its carrier, of several the first."""
        return self.law_between(block.name, block.carrier)[0]

    def restitution_of(self, block: BlockSpec) -> float:
        """Restitution of a block on its carrier, of several the first; 0: plastic impacts."""
        return self.law_between(block.name, block.carrier)[1]

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

    def poses(
        self, *, upright: bool = False, drift: tuple[float, float] = (0.0, 0.0)
    ) -> dict[str, Pose]:
        """For each block, by its name, the rigid motion from its own frame to its place.

        As in `solver.scene.places.poses`, which needs numpy.
        """
        from solver.scene.places import poses

        return poses(self.order, self.dimension, upright=upright, drift=drift)

    def to_dict(self) -> dict[str, Any]:
        """The scene as plain tables, every default written out."""
        return to_table(self)


def _refuse_unknown(where: str, name: str, names: Sequence[str]) -> None:
    """Refuse the name of a body that is not there."""
    if name not in names:
        raise SceneError(where, shown(name), " or ".join(map(shown, names)), nearest(name, names))
