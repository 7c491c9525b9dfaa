"""How the feet of contact points go over a face within a step, and the force rows that follow.

With the shape functions N at the feet before and after, the nodes x_c of the face, the frame (n, t)
of the step, bars for means and d for increments over the step (docs/method.md, "What carries"),

    e = dN . mean x_c = (e_n, e_t)                the way of the foot over the mean surface
    dg = (n - kappa t) . (dx - mean N dx_c),      kappa = e_n/e_t        the mean slope
    ds = (t/a) . (dx - mean N dx_c),              a = e_t/ds             the mean stretch

hold exactly, whatever the step and however many facets it crosses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.contact.projection import ContactKinematics, Projection
from solver.types import Array, Indices

STANDING_STILL = 1e-4
"""Part of a facet: a foot that moves by less has the local slope and stretch, one that moves by
twice as much or more those of its way; between the two they go over from one to the other."""


@dataclass(frozen=True, slots=True)
class FootWay:
    """The way of the feet over the mean surface of a step, in the frame of the face."""

    normal: Array
    """e_n, (m,), m."""
    tangential: Array
    """e_t, (m, d-1), m."""
    material: Array
    """ds, the way in the undeformed face, (m, d-1), m."""
    slope: Array
    """kappa where a foot moves, else the slope of the surface there, (m, d-1)."""
    stretch: Array
    """a likewise, (m, d-1, d-1)."""
    share: Array
    """How far slope and stretch are those of the way, 0 to 1, (m,)."""

    @classmethod
    def between(
        cls, old: ContactKinematics, new: ContactKinematics, frame: Array, facet: float
    ) -> FootWay:
        """The way between two instants, from feet and nodes at t_n and t_{n+1}.

        `frame` has rows normal and tangents, (d, d); `facet` is the length of the smallest facet,
        m.
        """
        first, last = old.foot, new.foot
        assert isinstance(first, Projection) and isinstance(last, Projection)
        assert old.carrier is not None and new.carrier is not None
        mean_nodes = 0.5 * (old.carrier.position + new.carrier.position)
        # e = dN . mean x_c
        e = (last.carried(mean_nodes) - first.carried(mean_nodes)) @ frame.T
        e_n, e_t = e[:, 0], e[:, 1:]
        ds = last.along - first.along
        kappa = 0.5 * (first.slope + last.slope)
        a = 0.5 * (first.stretch + last.stretch)
        squares = np.sum(ds**2, axis=1)
        share = np.clip(np.sqrt(squares) / (STANDING_STILL * facet) - 1.0, 0.0, 1.0)
        moving = np.flatnonzero(share)
        if len(moving):
            part = share[moving, None]
            kappa[moving] += part * _slope_change(kappa[moving], e_n[moving], e_t[moving])
            a[moving] += part[:, :, None] * _stretch_change(a[moving], e_t[moving], ds[moving])
        return cls(e_n, e_t, ds, kappa, a, share)

    def vectors(self, force: Array) -> Array:
        """Point forces in the frame of the face, (m, d), of normal and tangential ones, (m, d), N.

        They are f_n (n - kappa t) + a^-T f_t.
        """
        vectors = np.empty_like(force)
        vectors[:, 0] = force[:, 0]
        if force.shape[1] == 2:
            vectors[:, 1] = force[:, 1] / self.stretch[:, 0, 0] - force[:, 0] * self.slope[:, 0]
        else:
            transposed = self.stretch.swapaxes(1, 2)
            tangential = np.linalg.solve(transposed, force[:, 1:, None])[:, :, 0]
            vectors[:, 1:] = tangential - force[:, :1] * self.slope
        return vectors

    def work_defect(self, force: Array, pressed: Indices) -> float:
        """Work of these vectors less that of the forces (m, d), N, on (g, s), J.

        Only feet of closed points that hardly move have any: kappa . e_t is not e_n there,
        nor a^-1 e_t ds.
        """
        near = pressed[self.share[pressed] < 1]
        kappa, e_t = self.slope[near], self.tangential[near]
        lift = self.normal[near] - np.sum(kappa * e_t, axis=1)
        drag = np.linalg.solve(self.stretch[near], e_t[:, :, None])[:, :, 0] - self.material[near]
        return float(force[near, 0] @ lift + np.sum(force[near, 1:] * drag))


def _slope_change(kappa: Array, e_n: Array, e_t: Array) -> Array:
    """The least change of kappa after which kappa . e_t = e_n; in the plane kappa is e_n/e_t."""
    missing = e_n - np.sum(kappa * e_t, axis=1)
    return (missing / np.sum(e_t**2, axis=1))[:, None] * e_t


def _stretch_change(a: Array, e_t: Array, ds: Array) -> Array:
    """The least change of a after which a ds = e_t; in the plane a is e_t/ds."""
    missing = e_t - (a @ ds[:, :, None])[:, :, 0]
    along = ds / np.sum(ds**2, axis=1)[:, None]
    return missing[:, :, None] * along[:, None, :]
