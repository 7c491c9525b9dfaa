"""A step of one block on firm ground by a textbook semi-smooth Newton method.

It solves the equations of `solver.stepping` from the same guess to the same residual. In each
iteration dolfinx assembles the derivative of the averaged internal force, that of the contact terms
is added, with forces by the method of Alart and Curnier (1991) point by point, and MUMPS factorizes
the sum anew.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

from petsc4py import PETSc

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx.fem.petsc import assemble_matrix

from benchmarks.newton.contact_terms import ContactRows, PointLaw
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.elastic_forms import green_strain
from solver.compat import PackedForm
from solver.contact.body_points import SurfaceState
from solver.contact.kernels.nitsche import NitscheState
from solver.contact.kinematics import ContactIncrement, ContactKinematics, ForceWeights
from solver.stepping.balance import Balance, Contact, StepSolution
from solver.stepping.nonlinear import NewtonOutcome
from solver.stepping.system import Link, System
from solver.types import Array

MOST = 40
"""Iterations after which a step has failed."""

INERTIA = 0.05
"""Part of the inertia of a body in a step that is the length r of its contact law, divided by the
number of points that touch. Where r is more than one over the compliance of the body at all of them
together, as gamma_h w is, sticking points slip to and fro for ever."""

LAW = 1e-9
"""Largest breach of the contact law by forces that count as right, over the largest force."""

ROUND_OFF = 15.0
"""A residual below this many tolerances that falls no more is round-off, as in the program."""

PARTS = ("residual", "body", "contact", "factor", "substitution")
"""What an iteration spends its time on: body and contact are the assembly of the tangent."""

METIS = 5
"""MUMPS's number of nested dissection by METIS; the other orderings are no faster."""


class Placed(NamedTuple):
    """A step at one displacement, whatever the point forces."""

    u: Array
    """m."""
    smooth: Array
    """Residual without contact, N."""
    inertia: Array
    """M (u - u_n - dt v_n), kg m."""
    surface: SurfaceState
    """Contact points."""
    kinematics: ContactKinematics
    """Their gaps and tangential positions."""
    y: Array
    """Augmented positions, (p, d), m."""


class FullNewton:
    """Solves balances as `solver.stepping.contact_solve.ContactSolve` does, another way.

    Attributes:
        seconds: CPU seconds spent on each part so far.
        analysed: CPU seconds of the first factorization, with the analysis of the pattern.
    """

    def __init__(self, system: System, links: Sequence[Link]):
        """Take a system of one meshed body and its only interface."""
        (body,), (self._link,) = system.bodies, links
        assert isinstance(body, ElasticBody)
        self._system, self._body = system, body
        self._rows = ContactRows(self._link.interface)
        self._form, self._stress_weights = self._derivative()
        self.tangent = self._empty()
        self._inertia: dict[float, PETSc.Mat] = {}
        self._solution, self._right = self.tangent.createVecs()
        self._factor: PETSc.PC | None = None
        self.seconds = dict.fromkeys(PARTS, 0.0)
        self.analysed = 0.0

    def _derivative(self) -> tuple[PackedForm, tuple[ufl.Constant, ufl.Constant]]:
        """The derivative of (M13) by the displacement, and the weights of its strains."""
        from dolfinx import fem

        body, space, material = self._body, self._body.space, self._body.material
        new, old = (fem.Constant(space.mesh, value) for value in (1.0, 0.0))
        identity = ufl.Identity(body.dimension)
        strain = new * green_strain(ufl.grad(body.u)) + old * green_strain(ufl.grad(body.u_old))
        stress = material.lame * ufl.tr(strain) * identity + 2 * material.shear * strain
        middle = identity + ufl.grad(0.5 * body.u + 0.5 * body.u_old)
        degree = 2 * space.ufl_element().degree  # on quadrilaterals and hexahedra, as the program
        dx = ufl.dx(space.mesh, metadata={"quadrature_degree": degree})
        force = ufl.inner(middle * stress, ufl.grad(ufl.TestFunction(space))) * dx
        trial = ufl.TrialFunction(space)
        return PackedForm(ufl.derivative(force, body.u, trial)), (new, old)

    def _empty(self) -> PETSc.Mat:
        """A matrix with room for the body and for what couples contact points."""
        stiffness, own = self._body.stiffness_matrix, self._rows.pattern().tocoo()
        start, columns, _ = stiffness.getValuesCSR()
        shape = stiffness.size
        body = sp.csr_matrix((np.ones(len(columns)), columns, start), shape)
        unknowns = self._rows.unknowns
        contact = sp.csr_matrix((own.data, (unknowns[own.row], unknowns[own.col])), shape)
        whole = sp.csr_matrix(body + contact)
        whole.sort_indices()
        nothing = np.zeros(whole.nnz)
        csr = whole.indptr.astype(PETSc.IntType), whole.indices.astype(PETSc.IntType), nothing
        matrix = PETSc.Mat().createAIJ(shape, bsize=self._body.dimension, csr=csr)
        matrix.setLGMap(*stiffness.getLGMap())
        matrix.assemble()
        return matrix

    @contextmanager
    def _timed(self, part: str) -> Iterator[None]:
        """Add the CPU time meanwhile to that of a part."""
        begin = time.process_time()
        yield
        self.seconds[part] += time.process_time() - begin

    def solve(self, balance: Balance, guess: Array) -> StepSolution:
        """Solve the balance of a step from a guess of the displacement."""
        assert not balance.static
        (memory,), (weights,) = balance.contact, balance.weights
        law = PointLaw.of(self._link.interface, memory)
        tolerance, norms = balance.tolerance(self._system, guess).norm, list[float]()
        u, force, length = guess, memory.force, np.inf
        while True:
            with self._timed("residual"):
                here = self.place(balance, u)
                left = self.residual(balance, here, force)
            touching = np.count_nonzero(law.active & ((here.y[:, 0] < 0) | (force[:, 0] > 0)))
            inertia = INERTIA * weights.mass * self._body.mass / weights.contact
            length = min(length, inertia / max(touching, 1))
            norms.append(float(np.linalg.norm(left)))
            stagnates = len(norms) > 2 and norms[-1] > 0.5 * norms[-2]
            converged = norms[-1] <= (ROUND_OFF if stagnates else 1.0) * tolerance
            converged &= law.error(here.y, force, length) <= LAW
            if converged or len(norms) > MOST or not np.isfinite(norms[-1]):
                break
            force, change = law.linearized(here.y, force, length)
            with self._timed("residual"):
                right = self.residual(balance, here, force)
            read = self.assemble(balance, here, force, change)
            correction = -self._solved(right)
            u = u + correction
            moved = (read @ correction[self._rows.unknowns]).reshape(force.shape)
            force = force + np.einsum("pij,pj->pi", change, moved)
        outcome = NewtonOutcome(converged, len(norms) - 1, norms[-1], "full Newton")
        contact = Contact(here.surface, here.kinematics, force, law.bounds)
        contacts = [contact] if converged else []
        return StepSolution(u, contacts, left, here.inertia, outcome, np.empty(0))

    def place(self, balance: Balance, u: Array) -> Placed:
        """The body and its points at u."""
        interface = self._link.interface
        surface, kinematics = interface.observe(u, None)
        smooth = balance.smooth_residual(self._system, u)
        return Placed(u, *smooth, surface, kinematics, kinematics.augmented)

    def residual(self, balance: Balance, here: Placed, force: Array) -> Array:
        """Out-of-balance force with these point forces, N."""
        (memory,), (weights,), residual = balance.contact, balance.weights, here.smooth.copy()
        how = ForceWeights.of(contact=weights.contact, traction=weights.interface, sign=-1.0)
        increment = ContactIncrement(memory.seen, (here.surface, here.kinematics), force)
        self._link.interface.add_forces(increment, self._system.parts(residual, self._link), how)
        return residual

    def assemble(
        self, balance: Balance, here: Placed, force: Array, change: Array
    ) -> sp.csr_matrix:
        """Put the derivative of the residual, with df/dy, into the matrix; dy by the layer."""
        (memory,), (weights,) = balance.contact, balance.weights
        with self._timed("body"):
            structure = PETSc.Mat.Structure.SAME_NONZERO_PATTERN
            self._inertia_of(weights.mass).copy(self.tangent, structure)
            # Damping forces act on the strain's increment: both weights add up to 1.
            new, old = self._stress_weights
            new.value, old.value = weights.stiffness, 1.0 - weights.stiffness
            self._body.u.x.array[:], self._body.u_old.x.array[:] = here.u, balance.start
            assemble_matrix(self.tangent, self._form.form)
        with self._timed("contact"):
            before, after, rows = memory.surface, here.surface, self._rows
            assert isinstance(before, NitscheState) and isinstance(after, NitscheState)
            interface, weighted = self._link.interface, weights.contact * force
            how = ForceWeights.of(contact=weights.contact, traction=weights.interface, sign=1.0)
            pull = interface.traction_pull(weighted, how)
            terms, read = rows.tangent(before, after, pull, weights.contact * change)
            self.tangent.setValuesIJV(
                terms.indptr.astype(PETSc.IntType),
                rows.unknowns[terms.indices],
                terms.data,
                addv=PETSc.InsertMode.ADD,
                rowmap=rows.unknowns,
            )
            self.tangent.assemble()
        return read

    def _inertia_of(self, weight: float) -> PETSc.Mat:
        """The weighted mass in the pattern of the tangent."""
        if weight not in self._inertia:
            matrix = self.tangent.duplicate()
            matrix.zeroEntries()
            matrix.axpy(weight, self._body.mass_matrix, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
            self._inertia[weight] = matrix
        return self._inertia[weight]

    def _solved(self, residual: Array) -> Array:
        """K^-1 r with a factorization of the tangent as it is now."""
        with self._timed("factor"):
            first = self._factor is None
            if self._factor is None:
                self._factor = PETSc.PC().create(self.tangent.comm)
                self._factor.setType("lu")
                self._factor.setFactorSolverType("mumps")
                self._factor.setOperators(self.tangent)
                self._factor.setFactorSetUpSolverType()
                self._factor.getFactorMatrix().setMumpsIcntl(7, METIS)
            begin = time.process_time()
            self._factor.setOperators(self.tangent)
            self._factor.setUp()
            if first:
                self.analysed = time.process_time() - begin
        with self._timed("substitution"):
            self._right.array[:] = residual
            self._factor.apply(self._right, self._solution)
            return self._solution.array.copy()
