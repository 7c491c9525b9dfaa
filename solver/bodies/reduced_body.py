"""A meshed body that is reduced to few unknowns: it deforms, but linearly, and does not turn.

Rank 0 owns all its unknowns: d of each node kept, then the amplitudes of the shapes of the rest, in
groups of d. Forces are what does work on them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from mpi4py import MPI

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from solver.bodies.body import Body
from solver.bodies.craig_bampton import Bound, InnerBasis, ReducedMatrices, Shapes
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.kinematics import RigidMotion
from solver.bodies.surface_layer import Layer
from solver.parallel import global_sum
from solver.scene.damping import DampingSpec
from solver.scheme.generalized_alpha import GeneralizedAlpha, TangentWeights
from solver.types import Array


class DenseFactor:
    """Cholesky's factor of a symmetric positive definite matrix, some unknowns held."""

    name = "dense Cholesky"

    def __init__(self, matrix: Array, held: NDArray[np.int32], unknowns: int):
        """Factorize the matrix of the unknowns that are not held; what is held does not move.

        The first rank has all of the matrix, the others nothing; all know its unknowns.
        """
        self._held, own = held, matrix.copy()
        own[held], own[:, held] = 0.0, 0.0
        own[held, held] = 1.0
        self._factor = la.cho_factor(own, lower=True) if len(own) else None
        self.nbytes = 8.0 * unknowns**2
        """Memory of the factor, bytes; the same on all ranks."""

    def solve(self, right: Array) -> Array:
        """K^-1 r for one vector."""
        if self._factor is None:
            return right.copy()
        found = la.cho_solve(self._factor, right, check_finite=False)
        found[self._held] = 0.0
        return np.asarray(found)

    def solve_many(self, right: Array) -> Array:
        """K^-1 B for columns, (owned, n) in the order of Fortran, as the answer is."""
        return np.asfortranarray(self.solve(right))


class ReducedFacts(NamedTuple):
    """Data of a reduced body on all ranks."""

    name: str
    """Name in messages and files."""
    mass: float
    """kg."""
    rigidity: float
    """Order of magnitude of its stiffness against forces on its surface, N/m."""
    damping: DampingSpec
    """Rayleigh damping."""
    delay: float
    """Dashpots over springs to the ground, s."""
    dimension: int
    """Dimension d of space, 2 or 3."""
    unknowns: int
    """Numbers on rank 0, d of each node and of each group of amplitudes."""
    springs: bool
    """True if springs tie it to the ground."""
    full_unknowns: int
    """Unknowns of the mesh."""


class ReducedParts(NamedTuple):
    """Data of a reduced body on rank 0 alone."""

    nodes: Array
    """Places of the nodes that are kept, (kept, d), m."""
    fixed: NDArray[np.int32]
    """Unknowns that are held, rising."""
    matrices: ReducedMatrices
    """M, K, ..."""
    shapes: Shapes
    """Shapes that expand it to its mesh."""
    mesh: ElasticBody
    """The body that it stands for."""


class ReducedBody(Body):
    """Forces, energies and tangents of a reduced body; it offers what `ElasticBody` does.

    With M, K about the equilibrium under weight and K_0 of the undeformed body, all projected,

        f = f_0 + K ((1 - alpha_f) y_{n+1} + alpha_f y_n) + w_c beta_R/dt K_0 (y_{n+1} - y_n).
    """

    clamped = True

    def __init__(self, comm: MPI.Intracomm, facts: ReducedFacts, parts: ReducedParts | None):
        """Take what all ranks have, and on rank 0 the parts."""
        self.comm, self.name, self.mass = comm, facts.name, facts.mass
        self.rigidity = facts.rigidity
        self.damping, self.delay, self.dimension = facts.damping, facts.delay, facts.dimension
        self.unknowns, self.has_spring = facts.unknowns, facts.springs
        self.parts = parts
        """Data of rank 0; None on all ranks but the first."""
        d = self.dimension
        self.size = self.unknowns if parts is not None else 0
        self.owned, self.identity = self.size // d, np.eye(d)
        self.nodes = np.zeros((self.owned, d))
        """Places of the nodes that are kept; of the amplitudes that follow 0, m."""
        self.fixed: NDArray[np.int32] = np.empty(0, dtype=np.int32)
        self._axes = 1 if d == 2 else 3
        if parts is not None:
            self.kept = len(parts.nodes)
            self.nodes[: self.kept], self.fixed, own = parts.nodes, parts.fixed, parts.matrices
        else:
            nothing, self.kept = np.zeros((0, 0)), 0
            rows = np.zeros((d, 0)), np.zeros((self._axes, 0))
            own = ReducedMatrices(nothing, nothing, nothing, nothing, np.zeros(0), 0.0, *rows)
        self._own = own
        self.directional_mass = own.directional_mass
        self._viscous = bool(self.damping.stiffness)
        self._factorizations: dict[TangentWeights, DenseFactor] = {}
        self.factorizations = 0
        """Number of tangents factorized so far."""
        self.solvers: set[str] = set()
        """Names of the linear solvers that solved with them."""
        self._start: Array = np.zeros(self.size)
        self._constant: Array = own.constant
        self._weigh(1.0, 0.0, 0.0)

    def expanded(self, y: Array) -> Array:
        """Displacements or velocities of the whole mesh; on rank 0."""
        assert self.parts is not None
        return self.parts.shapes.expanded(y)

    def resultant(self, force: Array) -> Array:
        """Sum of the forces on the owned unknowns along each direction, (d,), N: on the nodes."""
        return np.asarray(force.reshape(-1, self.dimension)[: self.kept].sum(axis=0))

    def inertia(self, vector: Array) -> Array:
        """M y."""
        return self._own.mass @ vector

    def rigid_motion(self, u: Array, v: Array) -> RigidMotion:
        """Motion of the rigid body that has the same momentum and angular momentum."""
        rows = self.directional_mass / self.mass
        own = np.concatenate([rows @ u, rows @ v, self._own.spin @ v])
        d, total = self.dimension, global_sum(self.comm, own)
        return RigidMotion(total[:d], total[d : 2 * d], total[2 * d :], self.identity)

    def vibration(self, u: Array, v: Array, rotation: Array) -> float:
        """Mean square of a velocity v over the mass, less that of the motion as a whole, m2/s2."""
        own = np.concatenate([self.directional_mass @ v, [v @ self.inertia(v)]])
        total = global_sum(self.comm, own) / self.mass
        return max(0.0, float(total[-1] - total[:-1] @ total[:-1]))

    def begin_step(self, u_old: Array, scheme: GeneralizedAlpha, dt: float) -> None:
        """Fix what a step of length `dt` starts from."""
        viscous = scheme.contact_weight * self.damping.stiffness / dt
        self._weigh(1 - scheme.alpha_f, scheme.alpha_f, viscous)
        self._begin(u_old)

    def begin_static(self, u: Array) -> None:
        """Prepare for the elastic forces of a state itself."""
        self._weigh(1.0, 0.0, 0.0)
        self._begin(u)

    def _weigh(self, new: float, old: float, viscous: float) -> None:
        """Set the weights of forces at the end of a step, at its start and of damping."""
        weights = new, old, viscous
        if getattr(self, "_weights", None) != weights:
            self._weights = weights
            self._end = new * self._own.stiffness
            if viscous:
                self._end += viscous * self._own.undeformed

    def _begin(self, u: Array) -> None:
        """Let y be the unknowns at the start of a step."""
        _, old, viscous = self._weights
        self._start, self._constant = u, self._own.constant
        if old:
            self._constant = self._constant + old * (self._own.stiffness @ u)
        if viscous:
            self._constant = self._constant - viscous * (self._own.undeformed @ u)

    def internal_force(self, u: Array, *, static: bool = False) -> Array:
        """Averaged internal force in a step to y; with `static`, of that state itself."""
        if static:
            return self._own.constant + self._own.stiffness @ u
        return self._constant + self._end @ u

    def impulsive_force(self, u: Array, dt: float) -> Array | None:
        """C dy/dt by strain rates; None without damping."""
        if not self._viscous:
            return None
        return self.damping.stiffness / dt * (self._own.undeformed @ (u - self._start))

    def spring(self, vector: Array) -> Array | None:
        """Force of the springs to the ground for a displacement; None without them."""
        return self._own.spring @ vector if self.has_spring else None

    def round_off(self, u: Array, weights: TangentWeights) -> float:
        """Square of the residual that round-off leaves at u; this rank's part."""
        own = self._own
        scale = max(1.0, weights.stiffness) * np.diagonal(own.stiffness)
        scale = float(np.finfo(float).eps) * (scale + 0.1 * weights.mass * np.diagonal(own.mass))
        return float(((scale * u) ** 2).sum())

    def strain_energy(self, u: Array) -> float:
        """Energy of strain at y, on rank 0, J."""
        own = self._own
        return own.energy + float(own.constant @ u) + 0.5 * float(u @ (own.stiffness @ u))

    def increment_energy(self, u: Array) -> float:
        """dy.K dy, dy from where the step begins to y, on rank 0, J."""
        change = u - self._start
        return float(change @ (self._own.stiffness @ change))

    def restiffen(self, u: Array) -> bool:
        """False: its stiffness is what it is."""
        return False

    def factorization(self, weights: TangentWeights) -> DenseFactor:
        """The tangent for these weights, factorized once and kept."""
        if weights not in self._factorizations:
            own = self._own
            matrix = weights.interface * own.stiffness + weights.mass * own.mass
            if self._viscous:
                matrix += (weights.stiffness - weights.interface) * own.undeformed
            if self.has_spring:
                matrix += weights.spring * own.spring
            self._factorizations[weights] = DenseFactor(matrix, self.fixed, self.unknowns)
            self.factorizations += 1
            self.solvers.add(DenseFactor.name)
        return self._factorizations[weights]

    def mass_inverse(self) -> DenseFactor:
        """The factorized mass."""
        return DenseFactor(self._own.mass, self.fixed, self.unknowns)


class ReducedLayer(Layer):
    """Nodes of a face whose displacements follow from the unknowns, which all are on rank 0."""

    def __init__(self, comm: MPI.Intracomm, rows: Array):
        """Take the rows of the nodes, (size, d, unknowns); on other ranks without any unknowns."""
        self.comm, self.size, self.direct, self._rows = comm, len(rows), False, rows

    def part(self, chosen: NDArray[np.int64]) -> Layer:
        """The layer of some of its nodes, in the order of their places here."""
        return ReducedLayer(self.comm, self._rows[chosen])

    def _flat(self) -> Array:
        """The rows below one another, (size d, unknowns)."""
        return self._rows.reshape(-1, self._rows.shape[2])

    def gather(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of the face, (size, d, ...), from those of the owned unknowns, (n, d, ...)."""
        result = np.empty((self.size, *values.shape[1:]))
        if self.comm.rank == 0:
            rows = self._flat()
            result[:] = (rows @ values.reshape(rows.shape[1], -1)).reshape(result.shape)
        if self.comm.size > 1:
            self.comm.Bcast(result, root=0)
        return result

    def add(self, target: NDArray[np.float64], values: NDArray[np.float64]) -> None:
        """Add values of the face to those of the owned unknowns, in place."""
        if self.comm.rank == 0:
            rows = self._flat()
            target += (rows.T @ values.reshape(len(rows), -1)).reshape(target.shape)


class Reduction(NamedTuple):
    """The reduction of a mesh, in numbers that every rank has."""

    facts: ReducedFacts
    """The body."""
    modes: int
    """Number of modes."""
    shapes: int
    """Number of static shapes besides."""
    fastest: float
    """Frequency of the fastest mode, rad/s."""
    bound: Bound
    """Bound of what the modes left out may take."""
    touched: int
    """Number of nodes kept on the deck."""
    supported: int
    """Number of nodes kept at supports besides."""

    @classmethod
    def of(cls, facts: ReducedFacts, basis: InnerBasis, nodes: tuple[int, int]) -> Reduction:
        """The numbers of a basis, and those of nodes that are kept on the deck and at supports."""
        modes = basis.modes
        fastest = math.sqrt(float(basis.squared[modes - 1])) if modes else 0.0
        return cls(facts, modes, len(basis.squared) - modes, fastest, basis.bound, *nodes)

    def in_words(self) -> tuple[str, str, str, str]:
        """Unknowns, modes, nodes, and what modes left out may take."""
        bound, hertz = self.bound, 2 * math.pi
        highest = f"{bound.frequency / hertz:.3g} Hz"
        left = f"{100 * bound.part:.2g} %" if bound.part < math.inf else "any part"
        return (
            f"{self.facts.unknowns} unknowns instead of {self.facts.full_unknowns}",
            f"{self.modes} up to {self.fastest / hertz:.4g} Hz, and {self.shapes} static shapes",
            f"{self.touched} of the top, {self.supported} at supports",
            f"take at most {left} of mass times acceleration, up to {highest}",
        )
