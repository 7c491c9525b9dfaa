"""Nitsche contact with Coulomb friction between the points of a body and a rigid plane.

All point quantities are in the frame (normal, tangential) of the plane. With the gap g, the
tangential position s, the elastic traction T and gamma_h, everything is said in terms of the
augmented position

    y = (g, s) - T/gamma_h:   l_n = [-gamma_h y_n]_+,   l_t = projection of -gamma_h (y_t - anchor)

on |l_t| <= mu l_n. The anchor is the stick memory: it stays while a point sticks, follows (y_t +
l_t/gamma_h) while it slips, and is y_t while it is open. Point forces are f = w l (Chouly, Hild and
Renard; the memory and the merging of points are this program's).
"""

from __future__ import annotations

from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geometry.foundation import RigidFoundation
from solver.contact.points import ContactPoints, SurfaceState, compact

Array = NDArray[np.float64]


@dataclass(slots=True)
class ContactState:
    """Memory of the contact at one instant.

    Attributes:
        surface: Positions and tractions of all points.
        force: f = w l, (points, 2), N/m: normal, tangential; on the body.
        anchor: Stick memory, (points,), m.
        eligible: Points that may touch: of the coinciding points of a corner, the one whose face
            opposes the plane.
    """

    surface: SurfaceState
    force: Array
    anchor: Array
    eligible: NDArray[np.bool_]


class PlaneContact:
    """Kinematics, forces and energy of contact with a rigid plane."""

    def __init__(self, points: ContactPoints, plane: RigidFoundation, *, theta: int):
        """Set up the rows.

        Args:
            points: Contact points of the body.
            plane: What carries it.
            theta: 1 symmetric, 0 fewest terms, -1 skew Nitsche method.
        """
        self.points, self.theta = points, theta
        self.frame = np.array([plane.normal, plane.tangent])
        self.origin = np.asarray(plane.point)
        self.softness = 1.0 / (points.weight * points.gamma_h)
        self._inverse_gamma = 1.0 / points.gamma_h
        position, traction = points.position_rows(), points.traction_rows()
        scale = sp.diags(np.repeat(self._inverse_gamma, points.dimension))
        self.read_rows = compact(position - scale @ traction)
        self.force_rows = compact(position - theta * scale @ traction)
        self.position_rows, self.traction_rows = compact(position), traction
        self._corners = self._coinciding()
        # Scaled by the whole body: the layer of nodes grows when a face joins.
        places = np.column_stack([points.tag, np.round(points.reference / points.size, 7) + 0.0])
        self._keys: list[tuple[float, ...]] = [tuple(row) for row in places]

    def keys(self) -> list[tuple[float, ...]]:
        """What tells the points of a body apart, whatever faces have joined: face and place."""
        return self._keys

    def theta_matrix(self, like: PETSc.Mat) -> PETSc.Mat:
        """(theta/gamma_h) G_T^T w G_T, the part of the theta term that stands in every tangent.

        Args:
            like: A matrix of the body, for sizes and distribution.
        """
        d = self.points.dimension
        weight = np.repeat(self.theta * self.points.weight * self._inverse_gamma, d)
        local = sp.csr_matrix(self.traction_rows.T @ sp.diags(weight) @ self.traction_rows)
        unknowns = (
            (self.points.layer.nodes[:, None] * d + np.arange(d)).ravel().astype(PETSc.IntType)
        )
        matrix = PETSc.Mat().createAIJ(like.getSizes(), comm=like.comm)
        matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
        start, end = like.getOwnershipRange()
        for row in np.flatnonzero((unknowns >= start) & (unknowns < end)):
            part = slice(local.indptr[row], local.indptr[row + 1])
            matrix.setValues(unknowns[row], unknowns[local.indices[part]], local.data[part])
        matrix.assemble()
        return matrix

    def _coinciding(self) -> list[NDArray[np.int64]]:
        """Groups of points of different faces that share a place."""
        scale = self.points.size
        _, group = np.unique(
            np.round(self.points.reference / scale, 9), axis=0, return_inverse=True
        )
        members = [np.flatnonzero(group.ravel() == k) for k in range(group.max() + 1)]
        return [m for m in members if len(m) > 1]

    def eligible(self, rotation: Array) -> NDArray[np.bool_]:
        """At each corner the point whose face looks most against the plane; all other points."""
        mask = np.ones(self.points.count, dtype=bool)
        facing = self.points.normal @ rotation.T @ self.frame[0]
        for corner in self._corners:
            mask[corner] = False
            mask[corner[np.argmin(facing[corner])]] = True
        return mask

    def augmented(self, surface: SurfaceState) -> Array:
        """Y = (g, s) - T/gamma_h of all points, (points, 2), m."""
        y = surface.position - self.origin - self._inverse_gamma[:, None] * surface.traction
        return y @ self.frame.T

    def gaps(self, surface: SurfaceState) -> Array:
        """(g, s) of all points, m."""
        return (surface.position - self.origin) @ self.frame.T

    def start(self, surface: SurfaceState, rotation: Array) -> ContactState:
        """A state without contact forces."""
        y = self.augmented(surface)
        return ContactState(surface, np.zeros_like(y), y[:, 1].copy(), self.eligible(rotation))

    def turn(self, state: ContactState, rotation: Array) -> float:
        """Choose the points of corners anew; a force moves with its place to the other face.

        Returns:
            Interface energy lost by the exchange (weights differ), J/m; added to what contact
            dissipates.
        """
        eligible = self.eligible(rotation)
        if np.array_equal(eligible, state.eligible):
            return 0.0
        before = self.energy(state)
        y = self.augmented(state.surface)
        for corner in self._corners:
            new, old = corner[eligible[corner]][0], corner[state.eligible[corner]][0]
            if new != old:
                state.force[new], state.force[old] = state.force[old], 0.0
                state.anchor[new] = y[new, 1] + state.force[new, 1] * self.softness[new]
                state.anchor[old] = y[old, 1]
        state.eligible = eligible
        return before - self.energy(state)

    def nodal(
        self,
        old: SurfaceState,
        new: SurfaceState,
        force: Array,
        traction_weight: float,
        contact_weight: float,
    ) -> Array:
        """Nodal forces (layer nodes, d) of contact: w_c G^T f and the terms of theta.

        Args:
            old: Surface at t_n.
            new: Surface at t_{n+1}.
            force: Point forces f at t_{n+1}.
            traction_weight: 1 - alpha_f for the theta term int (theta/gamma_h) T.DT[v], else 0 to
                leave it out.
            contact_weight: w_c.
        """
        in_space = force @ self.frame
        result = contact_weight * (self.points.values_T @ in_space)
        if self.theta:
            pull = -contact_weight * in_space
            if traction_weight:
                averaged = traction_weight * new.traction + (1 - traction_weight) * old.traction
                pull += self.points.weight[:, None] * averaged
            pull *= self.theta * self._inverse_gamma[:, None]
            result += self.points.traction_gradient(old, new, pull)
        return result

    def energy(self, state: ContactState) -> float:
        """Energy of the interface, sum of w (l^2 - theta T^2)/(2 gamma_h), J/m."""
        stored = 0.5 * float(np.sum(state.force**2 * self.softness[:, None]))
        if self.theta:
            tractions = np.sum(state.surface.traction**2, axis=1)
            stored -= (
                0.5 * self.theta * float(tractions @ (self.points.weight * self._inverse_gamma))
            )
        return stored

    def theta_increment(self, old: SurfaceState, new: SurfaceState) -> float:
        """Theta sum of w |T_{n+1} - T_n|^2/gamma_h, J/m.

        It is the interface's part in the numerical dissipation.
        """
        if not self.theta:
            return 0.0
        change = np.sum((new.traction - old.traction) ** 2, axis=1)
        return self.theta * float(change @ (self.points.weight * self._inverse_gamma))

    def remember(
        self, old: ContactState, surface: SurfaceState, force: Array
    ) -> tuple[ContactState, float, float]:
        """The state after a step; what friction, closing and opening of points dissipated (J/m).

        Friction is minus the work of the tangential forces on the anchors. What contact takes is
        the work of the point forces against y that is neither stored in the interface nor lost in
        friction; for theta = 1 this is sum w |dl|^2/(2 gamma_h), never negative.
        """
        y_old, y = self.augmented(old.surface), self.augmented(surface)
        closed = force[:, 0] > 0
        anchor = y[:, 1] + np.where(closed, force[:, 1] * self.softness, 0.0)
        state = ContactState(surface, force, anchor, old.eligible)
        friction = -float(force[:, 1] @ (anchor - old.anchor))
        stored = 0.5 * float(np.sum((force**2 - old.force**2) * self.softness[:, None]))
        contact = -float(np.sum(force * (y - y_old))) - stored - friction
        if self.theta != 1:
            change = (surface.traction - old.surface.traction) @ self.frame.T
            contact -= (1 - self.theta) * float(
                np.sum(force * change * self._inverse_gamma[:, None])
            )
        return state, friction, contact
