"""Nitsche's contact terms of a block on firm ground: forces by the law, and their derivative.

With the residual r of (M22), the rows G of positions, T' of tractions at t_{n+1} and DT of their
discrete gradient, and the rows R of the floor's frame,

    y = R (x - T/gamma_h),   C = df/dy,   open, stick or slip by the law at y
    dr = -w_c (G - theta DT/gamma_h)^T R^T C R (G - T'/gamma_h)
         - (1 - alpha_f) DT^T (theta w/gamma_h) T' - what DT itself changes by
"""

from __future__ import annotations

from typing import NamedTuple

from petsc4py import PETSc

import numpy as np
import scipy.sparse as sp

from solver.contact.body_points import NitschePoints
from solver.contact.interface import Interface
from solver.contact.kernels.nitsche import NitscheState, TractionPull
from solver.contact.memory import Memory
from solver.law.friction import Bounds
from solver.types import Array, Mask


class PointLaw(NamedTuple):
    """Signorini and Coulomb at each point by itself, with the softness of Nitsche's method."""

    softness: Array
    """1/(gamma_h w), (p,), m/N."""
    anchor: Array
    """Stick memory, (p, d-1), m."""
    bounds: Bounds
    """Of friction."""
    active: Mask
    """Points that may touch."""

    @classmethod
    def of(cls, interface: Interface, memory: Memory) -> PointLaw:
        """The law of a step that starts from a memory; friction has one constant coefficient."""
        if not interface.law.constant or interface.beds is not None:
            raise ValueError("only constant friction without a bed")
        active = memory.may_touch | (memory.force[:, 0] > 0)
        return cls(interface.softness, memory.anchor, interface.bounds(memory.past), active)

    def error(self, y: Array, force: Array, length: float) -> float:
        """The largest difference of f and P(f - r (y + s f)), r and P as below, over the forces."""
        left = force - self._projected(self._trial(y, force, length))[0]
        return float(np.abs(left).max(initial=0.0)) / (float(np.abs(force).max(initial=0.0)) or 1.0)

    def linearized(self, y: Array, force: Array, length: float) -> tuple[Array, Array]:
        """Forces f and df/dy, (p, d, d), N/m, that settle f = P(f - r (y + s f)) to first order.

        P projects on the admissible forces (Alart and Curnier 1991), s is the softness, r a length.
        """
        nearest, change = self._projected(self._trial(y, force, length))
        stiff = (length * self.softness)[:, None, None]
        left = np.eye(y.shape[1]) - (1 - stiff) * change
        settled = force - np.linalg.solve(left, (force - nearest)[:, :, None])[:, :, 0]
        return settled, -length * np.linalg.solve(left, change)

    def _trial(self, y: Array, force: Array, length: float) -> Array:
        """F - r (y + s f), y from where points stick, (p, d), N."""
        way = y + self.softness[:, None] * force
        way[:, 1:] -= self.anchor
        return np.asarray(force - length * way)

    def _projected(self, trial: Array) -> tuple[Array, Array]:
        """The admissible forces nearest to trial ones, (p, d), and their derivative, (p, d, d)."""
        count, d = trial.shape
        closed = self.active & (trial[:, 0] > 0)
        limit = self.bounds.mu * trial[:, 0] + self.bounds.cohesion
        size = np.linalg.norm(trial[:, 1:], axis=1)
        slips = closed & (size > limit)
        force = np.where(closed[:, None], trial, 0.0)
        change = np.zeros((count, d, d))
        change[closed] = np.eye(d)
        way = trial[slips, 1:] / size[slips, None]
        share = limit[slips] / size[slips]
        force[slips, 1:] = limit[slips, None] * way
        across = np.eye(d - 1) - way[:, :, None] * way[:, None, :]
        change[slips, 1:, 1:] = share[:, None, None] * across
        change[slips, 1:, 0] = self.bounds.mu[slips, None] * way
        return force, change


class ContactRows:
    """Derivatives of positions and tractions of contact points by the nodes of their layer."""

    def __init__(self, interface: Interface):
        """Take the tables of an interface of a meshed body."""
        assert isinstance(interface.points, NitschePoints)
        points = interface.points.points
        self.interface, self.count, self._d = interface, points.count, points.dimension
        d, layer, rows = self._d, points.layer, points.rows
        nodes, k = rows.numbers[:, 1:], rows.numbers.shape[1] - 1
        self._share, self._slopes = rows.table[:, 0], rows.table[:, 1 + k : 1 + k + k * d]
        self._slopes = self._slopes.reshape(-1, k, d)
        self._stiff = rows.table[:, 1 + k + k * d :].reshape(-1, d, d, d)
        self._point, self._size = rows.numbers[:, 0], layer.size * d
        self._columns = (nodes[:, :, None] * d + np.arange(d)).reshape(len(nodes), -1)
        self._traction_rows = self._point[:, None] * d + np.arange(d)
        numbers = layer.numbers(np.arange(layer.size))
        self.unknowns = (numbers[:, None] * d + np.arange(d)).ravel().astype(PETSc.IntType)
        """Numbers of the layer's unknowns among the owned ones of the body."""
        self._position = sp.csr_matrix(points.position_rows())

    def pattern(self) -> sp.csr_matrix:
        """Entries that a tangent may have: all nodes that a point knows of are coupled by it."""
        rows = np.repeat(self._point, self._columns.shape[1])
        entries = np.ones(len(rows)), (rows, self._columns.ravel())
        known = sp.csr_matrix(entries, (self.count, self._size))
        return sp.csr_matrix(known.T @ known)

    def _split(self, state: NitscheState) -> tuple[Array, Array]:
        """F, (e, d, d), and S N, (e, d), of all evaluations."""
        own = state.values[2 * self.count :].reshape(-1, self._d + 1, self._d)
        return own[:, : self._d], own[:, self._d]

    def _gradient(self, F: Array, stress: Array) -> sp.csr_matrix:
        """Rows of F C(sym(F^T grad v)) N + grad v S N, averaged over evaluations, (p d, n d)."""
        through = np.einsum(
            "eic,ecjm,elj,eam->eial", F, self._stiff, F, self._slopes, optimize=True
        )
        block = 2 * through
        along = np.einsum("eam,em->ea", self._slopes, stress)
        for i in range(self._d):
            block[:, i, :, i] += along
        block *= self._share[:, None, None, None]
        e, d = len(block), self._d
        rows = np.repeat(self._traction_rows.ravel(), self._columns.shape[1])
        columns = np.broadcast_to(self._columns[:, None], (e, d, self._columns.shape[1]))
        entries = block.reshape(-1), (rows, columns.ravel())
        return sp.csr_matrix(entries, (self.count * d, self._size))

    def _bending(self, vector: Array, middle: tuple[Array, Array], new: Array) -> sp.csr_matrix:
        """Derivative of `vector`.DT[v] by the displacement at t_{n+1}, (n d, n d)."""
        (F, _), N, D = middle, self._slopes, self._stiff
        g = self._share[:, None] * vector[self._point]
        pulled = np.einsum("ei,eic->ec", g, F)
        # S N of the mean changes with F at t_{n+1}; F of the mean changes in C(sym(F^T grad v)) N.
        turn = np.einsum("ebi,eijm,elj,eam->ealb", N, D, F, N, optimize=True)
        block = np.einsum("ealb,eq->ealbq", turn, g)
        stretch = np.einsum("ebi,eijm,elj,eam->ealb", N, D, new, N, optimize=True)
        block += np.einsum("ealb,eq->ebqal", stretch, g)
        equal = np.einsum("ei,eijm,ebj,eam->eab", pulled, D, N, N, optimize=True)
        for i in range(self._d):
            block[:, :, i, :, i] += equal
        width = self._columns.shape[1]
        rows = np.repeat(self._columns, width, axis=1)
        columns = np.tile(self._columns, (1, width))
        entries = block.reshape(-1), (rows.ravel(), columns.ravel())
        return sp.csr_matrix(entries, (self._size, self._size))

    def tangent(
        self, before: NitscheState, after: NitscheState, pull: TractionPull, change: Array
    ) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Derivatives by the layer's unknowns: of the contact terms of a residual, N/m, and of y.

        Args:
            before: The points at t_n.
            after: At the iterate.
            pull: What the residual multiplies the gradient of the traction by, with sign 1.
            change: w_c df/dy, (p, d, d), N/m.
        """
        d, frame = self._d, pull.frame
        (F_old, old), (F, stress) = self._split(before), self._split(after)
        middle = (F_old + F) / 2, (old + stress) / 2
        traction, gradient = self._gradient(F, stress), self._gradient(*middle)
        inverse_gamma = sp.diags(np.repeat(self.interface.inverse_gamma, d))
        spread = sp.diags(np.repeat(pull.scale[:, 1], d))
        turned = np.einsum("ji,pjk,kl->pil", frame, change, frame)
        each = np.arange(self.count)
        C = sp.bsr_matrix((turned, each, np.arange(self.count + 1)))
        read = self._position - inverse_gamma @ traction
        act = self._position - spread @ gradient
        theta = sp.diags(np.repeat(pull.new * pull.scale[:, 0], d))
        averaged = pull.new * after.traction + pull.old * before.traction
        vector = pull.scale[:, :1] * averaged - pull.scale[:, 1:] * (pull.force @ frame)
        terms = act.T @ (C @ read) + gradient.T @ (theta @ traction)
        turn = sp.block_diag([frame] * self.count, format="csr")
        return -sp.csr_matrix(terms + self._bending(vector, middle, F)), sp.csr_matrix(turn @ read)
