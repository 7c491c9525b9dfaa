"""Contact where the edges of two faces cross, in space.

Corners and nodes of one face touch the other face; but the polygon in which two blocks touch has
corners, too, where an edge of the upper face crosses one of the lower face in plan. There the gap
is that between the edges along the normal n that both have, and the places on them are those that
lie on one line along n. With shape functions N at these places on the edges before and after a
step, bars for means and d for increments over the step,

    D = mean N_u dx_u - mean N_l dx_l         how far the one material place moved over the other
    a = dN_u . mean x_u,  b = dN_l . mean x_l     the ways of the crossing along the mean edges
    dg = m . D,  m = (a x b)/(n . (a x b))        since a and b are at right angles to m
    ds = t . D                                    slip, counted from the begin of each step

hold exactly, however far the crossing moves: forces f_n m + f_t t on the one body and minus that on
the other work exactly f . (y_{n+1} - y_n). The frames (n, t) stand still within a step.
"""

from __future__ import annotations

import numpy as np

from solver.contact.body_points import SurfaceState
from solver.contact.facet_target import DEEP, Face
from solver.contact.outline import Outline
from solver.contact.plane_target import FacetCarrier
from solver.contact.projection import ContactKinematics, EdgeInterpolation, in_frames, in_space
from solver.types import Array, Indices, Mask

PARALLEL = 1e-2
"""Edges that cross in plan at less than this angle (rad) do not: the polygon has hardly a corner
there, and the ends of the edges touch in its place. At still smaller angles a crossing would run
along the edges when they bend a little, and iterations would not converge."""

STEEP = 0.7
"""Least cosine between the normal of two edges and that of the lower face. Where it is steeper the
crossing is not where the bodies are nearest to each other: a corner is."""

FAR = 0.01
"""A face farther within the outline of the other than this part of its length crosses no edge."""

SHORT = 1e-7
"""A way from one segment to the next that is shorter than this part of them has the direction of
that on which it begins."""

ROUNDS, SETTLED = 6, 1e-13
"""How often a crossing is looked for on the segments where the last round left it, at most, and the
part of a segment by which a round has to move it for another one."""


class Crossings(FacetCarrier):
    """Where the four edges of a lower face are crossed by those of an upper one, all 16 pairs.

    Attributes:
        frame: Normal and tangents of each pair, (16, 3, 3).
        present: Pairs that cross, (16,).
        rest: Gaps from which pairs that have sunk in are not pushed out, since that would gain
            energy; 0 for others, (16,), m.
    """

    count = 16

    def __init__(self, upper: Outline, lower: Outline, top: Face, bottom: Face):
        """Set up.

        Args:
            upper: Outline of the face that looks down.
            lower: Outline of the face that looks up.
            top: The latter face itself, as what carries the former's nodes.
            bottom: The former face, as what the latter's outline presses on.
        """
        self.upper, self.lower, self.points = upper, lower, lower.points
        self._edges = np.divmod(np.arange(self.count), 4)
        # A corner of the upper face is carried up to this far beyond an edge, m; one of the lower
        # face only from this far within: between the two nothing is left out.
        self._carried = 0.9 * top.margin * top.facet
        self._reaches = 2 * abs(bottom.margin) * bottom.facet
        self._length = top.length
        self.frame: Array = np.tile(np.eye(3), (self.count, 1, 1))
        self.present: Mask = np.zeros(self.count, dtype=np.bool_)
        self.rest: Array = np.zeros(self.count)
        self._start: ContactKinematics | None = None

    def meet(
        self, edge: Array, face: SurfaceState, middle: tuple[Array, Array]
    ) -> ContactKinematics:
        """Frames and pairs of the coming step, and the seat from which its slip counts.

        Args:
            edge: Where the nodes of the upper outline are at the start, (n, 3).
            face: Those of the lower one.
            middle: Where both are expected in the middle of the step.
        """
        self._start = None
        if self._inside(*middle):
            self.present = np.zeros(self.count, dtype=np.bool_)
        else:
            self.present = self._turn(*middle)
            end = 2 * middle[0] - edge, 2 * middle[1] - face.position
            self.present = self.within(edge, face.position) | self.within(*end)
        seat = self.seat(edge, face)
        self.present &= seat.place[:, 0] > -DEEP * self._length
        self.rest = np.minimum(seat.place[:, 0], 0.0)
        self._start = seat
        return seat

    def _inside(self, edge: Array, face: Array) -> bool:
        """Whether all of the upper face is far within the lower one, as on a plate."""
        chords = self.lower.chords(face)
        inwards = np.cross(np.cross(chords[0], chords[1]), chords)
        inwards /= np.linalg.norm(inwards, axis=1)[:, None]
        corners = edge[self.upper.corners] @ inwards.T
        borders = np.sum(face[self.lower.corners] * inwards, axis=1)
        return bool(np.min(corners - borders) > FAR * self._length)

    def _turn(self, edge: Array, face: Array) -> Mask:
        """Turn the frames with the edges; which pairs have one."""
        i, j = self._edges
        over, under = self.upper.chords(edge), self.lower.chords(face)
        up = [np.cross(chords[0], chords[1]) for chords in (over, under)]
        up = [normal / np.linalg.norm(normal) for normal in up]
        over = over / np.linalg.norm(over, axis=1)[:, None]
        under = under / np.linalg.norm(under, axis=1)[:, None]
        normal = np.cross(over[i], under[j])
        rise = normal @ up[1]
        size = np.linalg.norm(normal, axis=1)
        good = (np.abs(rise) > PARALLEL) & (np.abs(rise) > STEEP * size) & (up[0] @ up[1] > 0.5)
        n = normal[good] / (np.sign(rise) * size)[good, None]
        self.frame[good] = np.stack([n, under[j[good]], np.cross(n, under[j[good]])], axis=1)
        return np.asarray(good)

    def within(self, edge: Array, face: Array) -> Mask:
        """Present pairs that cross within both edges, not where a corner touches the other face."""
        i, j = self._edges
        over, under = self.upper.chords(edge), self.lower.chords(face)
        sine = np.linalg.norm(np.cross(over[i], under[j]), axis=1)
        t, s = self._fractions(np.arange(self.count), edge, face)
        beyond = [
            np.minimum(x, 1 - x) * sine / np.linalg.norm(other, axis=1)
            for x, other in ((t, under[j]), (s, over[i]))
        ]
        return self.present & (beyond[0] > self._carried) & (beyond[1] > -self._reaches)

    def _fractions(self, pairs: Indices, edge: Array, face: Array) -> tuple[Array, Array]:
        """Where edges cross, as fractions of their chords."""
        i, j = (which[pairs] for which in self._edges)
        over, under = self.upper.chords(edge)[i], self.lower.chords(face)[j]
        apart = face[self.lower.corners[j]] - edge[self.upper.corners[i]]
        return self._solved(pairs, over, under, apart)

    def _solved(self, pairs: Indices, a: Array, b: Array, apart: Array) -> tuple[Array, Array]:
        """The x and y for which x a - y b is `apart` as seen along the normals; 0 if parallel."""
        flat = self.frame[pairs, 1:]
        (a0, a1), (b0, b1), (c0, c1) = (
            np.einsum("mij,mj->im", flat, vectors) for vectors in (a, b, apart)
        )
        area = b0 * a1 - a0 * b1
        area = np.where(area == 0, np.inf, area)
        return (b0 * c1 - b1 * c0) / area, (a0 * c1 - a1 * c0) / area

    def seat(self, position: Array, carrier: SurfaceState | None) -> ContactKinematics:
        """Gaps and slips at the crossings for positions of the upper outline's nodes."""
        assert carrier is not None
        place = np.zeros((self.count, 3))
        place[:, 0] = self._length
        pairs = np.flatnonzero(self.present)
        if not len(pairs):
            tip, foot = self.upper.nowhere(position), self.lower.nowhere(carrier.position)
            return ContactKinematics(
                place, carrier, self._for_all(pairs, foot), self._for_all(pairs, tip)
            )
        tip, foot = self._places(pairs, position, carrier.position)
        apart = tip.carried(position) - foot.carried(carrier.position)
        place[pairs, 0] = np.sum(apart * self.frame[pairs, 0], axis=1)
        seat = ContactKinematics(
            place, carrier, self._for_all(pairs, foot), self._for_all(pairs, tip)
        )
        if self._start is not None:
            slip = in_frames(self._moved(self._start, seat), self.frame)
            place[pairs, 1:] = slip[pairs, 1:]
        return seat

    def _places(
        self, pairs: Indices, edge: Array, face: Array
    ) -> tuple[EdgeInterpolation, EdgeInterpolation]:
        """Where the pairs cross on their edges: first on straight ones, then on the segments."""
        i, j = (which[pairs] for which in self._edges)
        t, s = self._fractions(pairs, edge, face)
        for _ in range(ROUNDS):
            (over, x), (under, y) = self.upper.locate(i, t), self.lower.locate(j, s)
            apart = self.lower.spots(under, y, face).carried(face)
            apart -= self.upper.spots(over, x, edge).carried(edge)
            ways = self.upper.tangents(over, x, edge), self.lower.tangents(under, y, face)
            dx, dy = self._solved(pairs, *ways, apart)
            x, y = x + dx, y + dy
            if max(np.abs(dx).max(), np.abs(dy).max()) < SETTLED:
                break
            t, s = self.upper.fraction(i, over, x), self.lower.fraction(j, under, y)
        return self.upper.spots(over, x, edge), self.lower.spots(under, y, face)

    def _for_all(self, pairs: Indices, spots: EdgeInterpolation) -> EdgeInterpolation:
        """The places of some pairs among those of all; the others have no weight."""
        k = spots.nodes.shape[1]
        numbers, values = (
            np.zeros((self.count, k + 1), dtype=np.int64),
            np.zeros((self.count, k + 1)),
        )
        numbers[pairs, :k], numbers[pairs, k] = spots.nodes, spots.segment
        values[pairs, :k], values[pairs, k] = spots.weights, spots.where
        return EdgeInterpolation(
            numbers[:, :k], values[:, :k], numbers[:, k], values[:, k], spots.position
        )

    def _moved(self, old: ContactKinematics, new: ContactKinematics) -> Array:
        """D: how far the places on the upper edges moved over those on the lower ones, (16, 3)."""
        over, under = (
            0.5 * (first.carried(change) + last.carried(change))
            for first, last, change in self._increments(old, new)
        )
        return over - under

    @staticmethod
    def _increments(
        old: ContactKinematics, new: ContactKinematics
    ) -> list[tuple[EdgeInterpolation, EdgeInterpolation, Array]]:
        """On the upper edges and on the lower ones: places before and after, motion of nodes."""
        pairs = (old.tip, new.tip), (old.foot, new.foot)
        found = []
        for first, last in pairs:
            assert isinstance(first, EdgeInterpolation) and isinstance(last, EdgeInterpolation)
            found.append((first, last, last.position - first.position))
        return found

    def vectors(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> Array:
        """Point forces as vectors in space such that their work on increments is exact."""
        vectors = np.zeros_like(force)
        pressed = np.flatnonzero(force.any(axis=1))
        if not len(pressed):
            return vectors
        a, b = (
            _way(outline, first, last, pressed)
            for outline, (first, last, _) in zip(
                (self.upper, self.lower), self._increments(old, new), strict=True
            )
        )
        frames, given = self.frame[pressed], force[pressed]
        normal = np.cross(a, b)
        normal /= np.sum(normal * frames[:, 0], axis=1)[:, None]
        vectors[pressed] = given[:, :1] * normal + in_space(given[:, 1:], frames[:, 1:])
        return vectors

    def rotate_frame(self, rotation: Array) -> None:
        """Its frames are those of the edges: `meet` turns them."""

    def work_defect(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> float:
        """Nothing: the work of the vectors is exact."""
        return 0.0

    def beyond_edge(self, seat: ContactKinematics) -> Mask | None:
        """Pairs that do not cross are not may_touch; none of the others is beyond an edge."""
        return None


def _way(
    outline: Outline, first: EdgeInterpolation, last: EdgeInterpolation, chosen: Indices
) -> Array:
    """The direction from one place to another on the mean edge, also where they are one."""
    mean = 0.5 * (first.position + last.position)
    begin, end = first.segment[chosen], last.segment[chosen]
    x, y = first.where[chosen], last.where[chosen]
    way = outline.tangents(begin, np.where(begin == end, 0.5 * (x + y), x), mean)
    chord = (last.carried(mean) - first.carried(mean))[chosen]
    long = np.sum(chord**2, axis=1) > SHORT**2 * np.sum(way**2, axis=1)
    return np.where(((begin != end) & long)[:, None], chord, way)
