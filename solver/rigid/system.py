"""Rigid blocks, the platform under them, and systems of them: starts, steps, rows.

The steps are compiled (`solver.kernels.world`); rows of the history are written here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.arrangement import Pose, level
from geometry.block import FACES, Block
from solver.excitation.forces import arm_of, factors, whole_force
from solver.history.engine_rows import energy_columns, platform_columns, rows_of, run_columns
from solver.history.events import Event, Meeting
from solver.history.history import scene_columns
from solver.history.link_columns import LinkRows
from solver.kernels.world import Body, Mobility, Steps, World
from solver.rigid.links import link_of
from solver.rigid.rows import BlockRows, quaternion_of, rotation_matrices
from solver.scene import BlockSpec, Scene
from solver.scene.foundation import Platform
from solver.scene.laws import GROUND, Law
from solver.scene.places import Drift
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array, Indices


def drift_of(scene: Scene) -> Drift:
    """Where the platform of a scene starts, along x and y, m.

    On an incline that is where the spring holds what it carries.
    """
    if not scene.has_platform or scene.time.initial != "static":
        return 0.0, 0.0
    if any(spec.tilt for spec in scene.blocks):
        return 0.0, 0.0
    mass, stiffness, _ = scene.platform()
    held, pull = (mass + scene.carried_mass) / stiffness, (*scene.gravity_vector[:-1], 0.0)
    return held * pull[0], held * pull[1]


def centre_of(shape: Block, pose: Pose) -> Array:
    """Where the centre of mass of a block is, m, (d,)."""
    return np.asarray(pose(np.array([shape.centre_of_mass(len(pose.place))]))[0])


TRIAL = 0.1
"""Forces at the start are those of a trial step of this part of the first one."""

FOLLOWING = (
    *("normal_force_N", "friction_force_N", "friction_force_second_N"),
    *("platform.acceleration_m_s2", "platform.acceleration_second_m_s2"),
    *("foundation.base_shear_N", "foundation.base_shear_second_N"),
    *(".force_N", ".shear_force_N", ".shear_force_second_N", "contact_points_closed"),
)
"""Columns of blocks, platform, ground and links that tell of the instant after a moment."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Advance:
    """Rows of steps, and how they went."""

    rows: Array
    """One row a step that succeeded, in the order of the system's `columns`."""
    rejected: int
    """Solutions that failed and were tried again with smaller steps."""
    failure: str | None
    """When and why it stopped early, or None."""
    met: Sequence[Meeting]
    """Bodies that met in these steps, by their times."""
    pairs: Array
    """What pairs of bodies did to one another (`World.pairs`); empty unless they are told."""
    events: Sequence[Event]
    """What happened to links."""
    unsettled: int
    """Steps that were taken though no solution met the tolerance."""


class RigidSystem:
    """Rigid blocks in the plane or in space, and how they stand at the moment.

    Bodies 0 to n - 1 are the blocks, body n is the ground, or the platform; its top is at level 0.
    """

    def __init__(self, scene: Scene, poses: Mapping[str, Pose] | None = None):
        """Start at t = 0, where the scene says, or where blocks stand by their names."""
        self.dimension = d = scene.dimension
        self.names = tuple(spec.name for spec in scene.blocks)
        self.time = 0.0
        self._forces = scene.forces
        self._moves = scene.has_platform
        shapes = {spec.name: spec.shape for spec in scene.blocks}
        self.columns = scene_columns(scene)
        """Names of the columns of the rows."""
        self._links = LinkRows(scene.links, d)
        drift = drift_of(scene)
        base = np.array([*drift[: d - 1], 0.0])
        placed = dict(poses or scene.poses(drift=drift))
        centres = {name: centre_of(shape, placed[name]) for name, shape in shapes.items()}
        scheme = GeneralizedAlpha(scene.time.rho_inf)  # of the platform's spring
        alphas = scheme.alpha_m, scheme.alpha_f, scheme.beta
        self._world = World(d, scene.gravity_vector, alphas, scene.contact.velocity_solve)
        for spec in scene.blocks:
            pose, centre = placed[spec.name], centres[spec.name]
            self._world.add(_body_of(self._world, spec, pose, centre))
        self._world.add(_base_of(self._world, scene.platform() if self._moves else None, base))
        numbers = {name: number for number, name in enumerate(self.body_names)}
        for link in scene.links:
            ends, at = placed | {GROUND: level(base)}, centres | {GROUND: base}
            self._world.link(link_of(link, ends, at, numbers))
        self._pushes = np.zeros((len(scene.forces), d))
        """Forces at factor 1, N, (forces, d)."""
        for k, force in enumerate(scene.forces):
            shape, pose = shapes[force.on], placed[force.on]
            self._world.force(numbers[force.on], arm_of(force, pose, shape, centres[force.on]))
            self._pushes[k] = whole_force(force, pose, shape)
        carriers = [[numbers[name] for name in spec.carriers] for spec in scene.blocks]
        laws, law_of = _laws_of(self.body_names, scene.laws.between)
        self._world.begin(laws, law_of, [*carriers, []])
        standing = [each[0] for each in carriers]
        self._written = BlockRows(shapes, standing, d)
        self._before = self._world.now()
        frames = rotation_matrices(self._before.rotation)
        self._lean = self._written.lean(self._before, frames, np.zeros(len(shapes)))[0]
        self._first = float(self._before.stored.sum())
        self.pairs: Array = np.empty((0, 4 + 4 * d))
        """What pairs of bodies did in the last step, as `World.pairs` of one step; at the start in
        the trial step from which the forces of `row` are; none unless they are told."""

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        d = self.dimension
        return d * (d + 1) // 2 * len(self.names) + (d - 1) * self._moves

    @property
    def rescued(self) -> dict[str, int]:
        """How many local contact problems Newton's method left to which other method."""
        return self._world.fallbacks()

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of all bodies, by their numbers."""
        return (*self.names, GROUND)

    def tell_pairs(self, *, every: bool) -> None:
        """Tell from here on what pairs do in every step, or in the last one of each `advance`."""
        self._world.tell_pairs(every=every)

    @property
    def deepest(self) -> tuple[float, float, str, str] | None:
        """The largest overlap at the start of any step: depth (m), time (s), names of both."""
        known = self._world.counts()
        first, second = int(known["deepest_a"]), int(known["deepest_b"])
        if first < 0:
            return None
        names = self.body_names
        return known["deepest"], known["deepest_at"], names[first], names[second]

    @property
    def largest_defect(self) -> float:
        """Largest error of velocity in a step that met no tolerance, m/s."""
        return self._world.counts()["largest_defect"]

    def _meetings(self) -> list[Meeting]:
        """The bodies that met since the last call, by their times."""
        names, found = self.body_names, []
        for met in sorted(self._world.collisions(), key=lambda met: met.time):
            meeting = Meeting.of(
                met.time,
                (names[met.first], names[met.second]),
                met.normal,
                met.impulse,
                speeds=(met.approach, met.departure, met.brought),
                spins=(met.spin, met.later_spin),
                lost=met.energy,
            )
            found.append(meeting)
        return found

    def advance(
        self,
        count: int,
        dt: float,
        ground: Array | None = None,
        smallest: float = 0.0,
        mean: Array | None = None,
    ) -> Advance:
        """Run `count` steps; one that fails is divided down to the smallest, by default dt / 1024.

        `ground`, (count + 1, d), has its accelerations at the ends of the steps, linear in between,
        m/s2; None: it stands. `mean`, (count, d), has those over the steps, where they are not
        those of the ends.
        """
        motion, shift = _ground_of_steps(count, self.dimension, ground, mean)
        before, unsettled = self._before, self._world.counts()["unsettled"]
        times = self.time + dt * np.arange(count + 1)
        pushes = factors(self._forces, times)[..., None] * self._pushes
        steps = self._world.run(count, dt, smallest or dt / 1024, motion, shift, pushes)
        done, pairs = len(steps.closed), self._world.pairs()
        happened: tuple[Event, ...] = ()
        rows: Array = np.empty((0, len(self.columns)))
        if done:
            taken = before.followed_by(steps)
            rows = self._rows(taken, times[1 : done + 1], dt, motion[1 : done + 1])
            happened = tuple(self._links.events(taken.links, times[1 : done + 1]))
            self._before = steps.last()
            self.pairs = pairs[pairs[:, 0] == done - 1]
            self.pairs[:, 0] = 0
        self.time += dt * done
        rejected = int(self._before.halved[0] - before.halved[0])
        failure = f"no solution of a step at {self.time:.6g} s" if done < count else None
        return Advance(
            rows=rows,
            rejected=rejected,
            failure=failure,
            met=self._meetings(),
            pairs=pairs,
            events=happened,
            unsettled=int(self._world.counts()["unsettled"] - unsettled),
        )

    def _rows(self, steps: Steps, times: Array, dt: float, ground: Array) -> Array:
        """The rows of steps that end at some times, s, all but the first one, which they follow."""
        known, self._lean = self._written.columns(steps, dt, self._lean)
        known |= run_columns(times, dt, np.diff(steps.iterations), steps.closed[1:], ground.T)
        if self._moves:
            drift, velocity = steps.centre[1:, -1].T, steps.velocity[:, -1].T
            gained, shear = np.diff(velocity) / dt, steps.ground_impulse[1:].T / dt
            known |= platform_columns(drift[:-1], velocity[:-1, 1:], gained[:-1], shear)
        known |= self._links.columns(steps.links[1:])
        kinetic, gravity, spring = steps.stored[1:].T
        taken, friction, damping, contact, numerical = steps.exchanged[1:].T
        stored = kinetic, 0.0, gravity, spring, 0.0
        exchanged = taken, friction, damping, 0.0, contact, numerical
        known |= energy_columns(stored, exchanged, self._first)
        return rows_of(self.columns, known, len(times))

    def saved(self) -> dict[str, Any]:
        """How everything stands at the moment, for `resume`."""
        lean, pairs = self._lean.copy(), self.pairs.copy()
        return {"time": self.time, "world": self._world.saved(), "lean": lean, "pairs": pairs}

    def resume(self, saved: dict[str, Any]) -> None:
        """Go back to where everything stood when it was saved."""
        self.time, self._lean = saved["time"], saved["lean"].copy()
        self.pairs = saved["pairs"].copy()
        self._world.restore(saved["world"])
        self._before = self._world.now()

    def row(self, dt: float, ground: Sequence[float] | None = None) -> Array:
        """The row of this moment, before a step dt (s); its forces are those of the next instant.

        The ground has an acceleration, m/s2; None: it stands.
        """
        d, short, saved = self.dimension, TRIAL * dt, self.saved()
        motion = np.tile(np.zeros(d) if ground is None else np.array(ground, float), (2, 1))
        trial = self.advance(1, short, motion, short / 1024)
        forces = self._before.links[..., d : 2 * d].copy()
        self.resume(saved)
        self._before.links[..., d : 2 * d] = forces
        self.pairs = trial.pairs
        now = self._before.followed_by(self._before)
        row = self._rows(now, np.array([self.time]), dt, motion[:1])[0]
        if not trial.failure:  # else the forces are not known; the step that follows fails, too
            taken = [k for k, name in enumerate(self.columns) if name.endswith(FOLLOWING)]
            row[taken] = trial.rows[0, taken]
        return row

    @property
    def link_numbers(self) -> Array:
        """Numbers of all links at the moment, (links, 3 d + 3), for `LinkStates.split`."""
        return self._before.links[0]

    @property
    def drift(self) -> Array:
        """Displacement of the platform, m, (d - 1,)."""
        return self._before.centre[0, -1, :-1].copy()

    @property
    def drift_velocity(self) -> Array:
        """Velocity of the platform, m/s, (d - 1,)."""
        return self._before.velocity[0, -1, :-1].copy()

    def centre(self, block: int) -> Array:
        """Centre of mass of a block, m."""
        return self._before.centre[0, block].copy()

    def angle(self, block: int) -> float:
        """Angle of a block in the plane, rad, clockwise, not wrapped."""
        return -float(self._before.turned[0, block, 0])

    def rotation(self, block: int) -> Array:
        """Rotation matrix of a block."""
        return rotation_matrices(self._before.rotation[0, block])

    def velocity(self, block: int) -> Array:
        """Velocity of the centre of mass of a block, m/s."""
        return self._before.velocity[0, block].copy()

    def angular_velocity(self, block: int) -> Array:
        """Angular velocity of a block, rad/s: in the plane clockwise, (1,), in space a vector."""
        spin = self._before.spin[0, block]
        return -spin if self.dimension == 2 else spin.copy()


def _body_of(world: World, spec: BlockSpec, pose: Pose, place: Array) -> Body:
    """A block as a body of the compiled world, with its centre at a place, m."""
    shape, turn = spec.shape, pose.rotation
    centre = np.array(shape.centre_of_mass(len(turn)))
    if shape.solid is None:
        pieces = [(np.array(shape.corners(len(turn))) - centre, FACES)]
    else:
        pieces = [(part.corners - centre, part.faces) for part in shape.solid.parts]
    if len(turn) == 2:
        return Body(
            shape=[world.polygon(corners) for corners, _ in pieces],
            mass=shape.mass,
            thickness=shape.thickness,
            inertia=shape.rotary_inertia,
            centre=place,
            rotation=math.atan2(turn[1, 0], turn[0, 0]),
            velocity=spec.velocity,
            spin=-np.array(spec.spins),
        )
    return Body(
        shape=[world.polyhedron(*piece) for piece in pieces],
        mass=shape.mass,
        inertia=shape.principal_inertias if shape.is_even else np.array(shape.inertia_tensor),
        centre=place,
        rotation=quaternion_of(turn),
        velocity=spec.velocity,
        spin=turn.T @ spec.spins,
    )


def _base_of(world: World, platform: Platform | None, place: Array) -> Body:
    """The ground, or the platform at a place, m, whose inertia balances its spring at the start."""
    shape = world.half_space()
    if platform is None:
        return Body(shape=shape, mobility=Mobility.FIXED)
    return Body(
        shape=shape,
        mobility=Mobility.PLATFORM,
        mass=platform.mass,
        stiffness=platform.stiffness,
        damping=platform.damping,
        spring_force=-platform.stiffness * place,
        centre=place,
    )


def _laws_of(
    names: Sequence[str], between: Callable[[str, str], Law]
) -> tuple[list[Array], Indices]:
    """All laws, and the number of that of each pair of bodies, (n, n), by their names."""
    numbers: dict[Law, int] = {}
    law_of = np.zeros((len(names), len(names)), dtype=np.int64)
    for i, first in enumerate(names):
        for j in range(i):
            law_of[i, j] = law_of[j, i] = numbers.setdefault(between(first, names[j]), len(numbers))
    laws = [
        np.array([s.static, s.dynamic, s.decay, s.cohesion, float(s.cohesion_lost), restitution])
        for s, restitution in numbers
    ]
    return laws, law_of


def _ground_of_steps(
    count: int, dimension: int, ground: Array | None, mean: Array | None
) -> tuple[Array, Array]:
    """Accelerations of the ground at the ends of steps, and by how much both ends of each shift.

    Within a step, and the pieces into which events cut it, the ground's acceleration is linear; the
    shift gives it the right mean, so that no impulse goes missing whatever happens in between.
    """
    if ground is None:
        return np.zeros((count + 1, dimension)), np.zeros((count, dimension))
    ground = np.ascontiguousarray(ground, dtype=np.float64)
    if mean is None:
        return ground, np.zeros((count, dimension))
    return ground, np.ascontiguousarray(mean - (ground[1:] + ground[:-1]) / 2)
