"""Contact where the edges of two faces cross, in space.

Corners and nodes of one face touch the other face; but the polygon in which two blocks touch has
corners, too, where an edge of the upper face crosses one of the lower face in plan. There the gap
is that between the edges along the normal n that both have, and the places on them are those that
lie on one line along n. With shape functions N at these places on the edges before and after a
step, bars for means and d for increments over the step,

    D = mean N_u dx_u - mean N_l dx_l         how far the one material place moved over the other
    a = dN_u . mean x_u,  b = dN_l . mean x_l     increments of the crossing along the mean edges
    dg = m . D,  m = (a x b)/(n . (a x b))        since a and b are at right angles to m
    ds = t . D                                    slip, counted from the begin of each step

hold exactly, however far the crossing moves: forces f_n m + f_t t on the one body and minus that on
the other work exactly f . (y_{n+1} - y_n). The frames (n, t) stand still within a step.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geometry.polygon import area_of, to_segment
from solver.contact.body_points import FacePoints, SurfaceState
from solver.contact.carriers import Face, FacetCarrier
from solver.contact.interface import Interface
from solver.contact.kinematics import (
    ContactKinematics,
    EdgeInterpolation,
    Observed,
    in_frames,
    in_space,
)
from solver.contact.memory import Memory
from solver.scene import Bed, FrictionSpec
from solver.types import Array, Indices, Mask


def distance_inside(places: Array, ring: Array) -> Array:
    """How far places in the plane, (m, 2), are within a convex polygon, (n, 2), in any sense, m."""
    sides = np.roll(ring, -1, axis=0) - ring
    sides = sides / np.linalg.norm(sides, axis=1)[:, None]
    off = places[:, None] - ring
    depth = sides[:, 0] * off[..., 1] - sides[:, 1] * off[..., 0]
    return np.asarray(np.min(depth * np.sign(area_of(ring)), axis=1))


def distance_to_edges(places: Array, ring: Array) -> Array:
    """Distance of places along a face, (m, t), from the edges of a polygon, (n, t), m.

    On a line (t = 1) from the nearest of its points.
    """
    if ring.shape[1] == 1:
        return np.asarray(np.abs(places - ring.T).min(axis=1))
    apart = to_segment(places[:, None], ring, np.roll(ring, -1, axis=0))
    return np.asarray(apart.min(axis=1))


def _edges_of(rings: Sequence[Array]) -> tuple[Array, Array]:
    """Begins and ends of the edges around a face along its tangents, anticlockwise, (count, 2).

    By corners around the pieces of the face, that of the outermost first.
    """
    if area_of(rings[0]) < 0:
        rings = [ring[::-1] for ring in rings]
    ends = [np.roll(ring, -1, axis=0) for ring in rings]
    return np.concatenate(rings), np.concatenate(ends)


class Outline:
    """The edges of a flat face, counterclockwise as seen from above (along its frame).

    Attributes:
        points: The nodes on the outline.
        count: Number of edges.
        corners: Numbers of the nodes at which the edges begin, (count,).
    """

    def __init__(self, points: FacePoints, degree: int, frame: Array, rings: Sequence[Array]):
        """Take the nodes on the outline; between them it has a polynomial degree of 1 or 2.

        The frame has the normal of who sees it from above and the tangents, in the undeformed body.
        The rings have the corners there, (n, 3), m.
        """
        self.points, self._degree = points, degree
        level = points.reference @ frame[1:].T
        near = 1e-9 * float(np.ptp(level, axis=0).max())
        begins, ends = _edges_of([ring @ frame[1:].T for ring in rings])
        self.count = len(begins)
        pieces: list[Indices] = []
        starts: list[float] = []
        lengths: list[float] = []
        corners: list[int] = []
        finals: list[int] = []
        ways = ends - begins
        sizes = np.linalg.norm(ways, axis=1)
        ways = ways / sizes[:, None]
        for edge, start in enumerate(begins):
            along, off = ways[edge], level - start
            far = off @ along
            on = np.flatnonzero(
                (np.abs(along[0] * off[:, 1] - along[1] * off[:, 0]) < near)
                & (far > -near)
                & (far < sizes[edge] + near)
            )
            chain = on[np.argsort(far[on])]
            place = far[chain]
            place = (place - place[0]) / (place[-1] - place[0])
            for k in range(0, len(chain) - 1, degree):
                pieces.append(chain[k : k + degree + 1])
                starts.append(edge + place[k])
                lengths.append(place[k + degree] - place[k])
            corners.append(int(chain[0]))
            finals.append(int(chain[-1]))
        self.corners: Indices = np.array(corners)
        self._ends: Indices = np.array(finals)
        self._pieces: Indices = np.array(pieces, dtype=np.int64)
        self._begins, self._lengths = np.array(starts), np.array(lengths)
        self._first = np.searchsorted(self._begins, np.arange(float(self.count)))
        self._last = np.append(self._first[1:], len(pieces)) - 1

    def chords(self, position: Array) -> Array:
        """From end to end of each edge, (count, 3), for positions of the nodes."""
        return position.take(self._ends, axis=0) - position.take(self.corners, axis=0)

    def locate(self, edge: Indices, fraction: Array) -> tuple[Indices, Array]:
        """Segments and places on them at fractions of the lengths of edges, and beyond their ends.

        The fraction is that in the undeformed body.
        """
        found = np.searchsorted(self._begins, edge + np.clip(fraction, 0.0, 1.0), "right") - 1
        found = np.clip(found, self._first[edge], self._last[edge])
        return found, (edge + fraction - self._begins[found]) / self._lengths[found]

    def fraction(self, edge: Indices, segment: Indices, where: Array) -> Array:
        """Fractions of the lengths of edges, for places on segments: the inverse of `locate`."""
        return self._begins[segment] - edge + where * self._lengths[segment]

    def spots(self, segment: Indices, where: Array, position: Array) -> EdgeInterpolation:
        """The places at `where` on segments, for positions of the nodes."""
        x = where
        if self._degree == 1:
            weights = np.stack([1 - x, x], axis=1)
        else:
            weights = np.stack([(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1)], axis=1)
        return EdgeInterpolation(self._pieces[segment], weights, segment, x, position)

    def nowhere(self, position: Array) -> EdgeInterpolation:
        """No place at all."""
        empty = np.zeros(0)
        return self.spots(empty.astype(np.int64), empty, position)

    def tangents(self, segment: Indices, where: Array, position: Array) -> Array:
        """Derivatives of the place along segments, (m, 3)."""
        x = where
        if self._degree == 1:
            slopes = np.stack([-np.ones_like(x), np.ones_like(x)], axis=1)
        else:
            slopes = np.stack([4 * x - 3, 4 - 8 * x, 4 * x - 1], axis=1)
        return (slopes[:, None, :] @ position[self._pieces[segment]])[:, 0]


PARALLEL_ANGLE = 1e-2
"""Edges that enclose less than this angle (rad) are parallel and do not cross. The polygon in which
two faces touch has hardly a corner there, and a crossing would run along both edges when they turn
or bend a little. Where such an edge enters the other face, it touches along that face's normal."""

STEEPEST_COSINE = 0.5
"""Least cosine between the normal of two edges and that of the lower face: 60 degrees, as for the
faces themselves. Where it is steeper, a corner is nearer than the crossing."""

TURNED_AWAY_COSINE = 0.5
"""Least cosine between the normal of the lower face and the opposite one of the upper face."""

SHORT_WAY = 1e-7
"""Part of a segment: a shorter increment from one segment to the next has the direction of the
segment on which it begins."""

CARRIED_SHARE = 0.9
"""Part of its margin up to which the lower face is taken to carry a corner beyond its edge."""

ONE_PLACE = 1e-4
"""Part of a facet within which a crossing and a corner are at one place."""

CROSSING_ROUNDS = 6
"""Rounds of Newton's method for a crossing, at most."""

CROSSING_SETTLED = 1e-13
"""Part of a segment that a round has to move a crossing by for another round."""


NEXT, LAST = [1, 2, 0], [2, 0, 1]
"""The axes after each axis, and those before it."""


class Crossings(FacetCarrier):
    """Contacts between the edges of a lower face and those of an upper one; of rectangles 16 pairs.

    Attributes:
        count: Number of pairs.
        upper: Outline of the face that points down.
        lower: Outline of the face that points up.
        points: The nodes of the lower outline.
        reference_frame: Normal and tangents of each pair before it ever crosses, (count, 3, 3).
    """

    def __init__(self, upper: Outline, lower: Outline, top: Face, bottom: Face):
        """Take the outlines of a face that points down and of one that points up, and the faces.

        The latter is what carries the former's nodes, the former what the latter's outline presses
        on.
        """
        self.upper, self.lower, self.points = upper, lower, lower.points
        self.count = upper.count * lower.count
        self._edges = np.divmod(np.arange(self.count), lower.count)
        # A corner of the upper face is carried up to this far beyond an edge, m; one of the lower
        # face only from this far within: between the two nothing is left out.
        self._carried = CARRIED_SHARE * top.margin * top.facet
        self._reaches = 2 * abs(bottom.margin) * bottom.facet
        self._length, self._facet = top.length, min(top.facet, bottom.facet)
        none = np.zeros(0, dtype=np.int64)
        self._nowhere = tuple(
            self._for_all(none, line.nowhere(line.points.reference)) for line in (lower, upper)
        )
        self.reference_frame: Array = np.tile(np.eye(3), (self.count, 1, 1))

    def detect(
        self, edge: Array, face: SurfaceState, middle: tuple[Array, Array], frame: Array
    ) -> tuple[ContactKinematics, Mask]:
        """The kinematics from which slip counts in the coming step, and the pairs that cross in it.

        Args:
            edge: Where the nodes of the upper outline are at the start, (n, 3).
            face: Those of the lower one.
            middle: Where both are expected in the middle of the step.
            frame: Frames so far, (count, 3, 3), which pairs that do not cross keep.
        """
        frame, framed = self._turned(*middle, frame)
        end = 2 * middle[0] - edge, 2 * middle[1] - face.position
        present = self.within(edge, face.position, frame, framed)
        present = present | self.within(*end, frame, framed)
        return self.kinematics(edge, face, frame, present), present

    @property
    def one_place(self) -> float:
        """Distance within which a crossing and a corner are at one place, m."""
        return ONE_PLACE * self._facet

    def _turned(self, edge: Array, face: Array, before: Array) -> tuple[Array, Mask]:
        """Frames that have turned with the edges, and which pairs have one; others as before."""
        i, j = self._edges
        over, under = self.upper.chords(edge), self.lower.chords(face)
        up = [crossed(chords[0], chords[1]) for chords in (over, under)]
        up = [normal / np.linalg.norm(normal) for normal in up]
        over = over / np.linalg.norm(over, axis=1)[:, None]
        under = under / np.linalg.norm(under, axis=1)[:, None]
        normal = crossed(over[i], under[j])
        rise = normal @ up[1]
        size = np.linalg.norm(normal, axis=1)
        crossing = np.abs(rise) > PARALLEL_ANGLE
        level = np.abs(rise) > STEEPEST_COSINE * size
        good = crossing & level & (up[0] @ up[1] > TURNED_AWAY_COSINE)
        n = normal[good] / (np.sign(rise) * size)[good, None]
        frame = before.copy()
        frame[good] = np.stack([n, under[j[good]], crossed(n, under[j[good]])], axis=1)
        return frame, np.asarray(good)

    def within(self, edge: Array, face: Array, frame: Array, pairs: Mask) -> Mask:
        """The pairs that cross within both edges, not where a corner touches the other face."""
        if not pairs.any():
            return pairs
        i, j = self._edges
        over, under = self.upper.chords(edge), self.lower.chords(face)
        sine = np.linalg.norm(crossed(over[i], under[j]), axis=1)
        t, s = self._fractions(np.arange(self.count), edge, face, frame)
        beyond = [
            np.minimum(x, 1 - x) * sine / np.linalg.norm(other, axis=1)
            for x, other in ((t, under[j]), (s, over[i]))
        ]
        return pairs & (beyond[0] > self._carried) & (beyond[1] > -self._reaches)

    def _fractions(
        self, pairs: Indices, edge: Array, face: Array, frame: Array
    ) -> tuple[Array, Array]:
        """Crossings as fractions of the chords of both edges."""
        i, j = (which[pairs] for which in self._edges)
        over, under = self.upper.chords(edge)[i], self.lower.chords(face)[j]
        apart = face[self.lower.corners[j]] - edge[self.upper.corners[i]]
        return _solved(frame[pairs], over, under, apart)

    def kinematics(
        self,
        position: Array,
        carrier: SurfaceState | None,
        frame: Array,
        present: Mask | None = None,
        start: ContactKinematics | None = None,
    ) -> ContactKinematics:
        """Gaps and slips at the crossings for positions of the upper outline's nodes.

        Args:
            position: The positions, (n, 3), m.
            carrier: Of the lower outline.
            frame: Normal and tangents of each pair, (count, 3, 3).
            present: Pairs that cross, (count,); None: none.
            start: From which slip counts; None: from here.
        """
        assert carrier is not None
        place = np.zeros((self.count, 3))
        place[:, 0] = self._length
        pairs = np.empty(0, dtype=np.int64) if present is None else np.flatnonzero(present)
        foot = self._nowhere[0].at(carrier.position)
        own = self._nowhere[1].at(position)
        if len(pairs):
            upper, lower = self._places(pairs, position, carrier.position, frame)
            apart = upper.carried(position) - lower.carried(carrier.position)
            place[pairs, 0] = np.sum(apart * frame[pairs, 0], axis=1)
            foot, own = self._for_all(pairs, lower), self._for_all(pairs, upper)
        kinematics = ContactKinematics(place, place, frame, carrier, foot, own)
        if start is not None and len(pairs):
            slip = in_frames(self._moved(start, kinematics), frame)
            place[pairs, 1:] = slip[pairs, 1:]
        return kinematics

    def _places(
        self, pairs: Indices, edge: Array, face: Array, frame: Array
    ) -> tuple[EdgeInterpolation, EdgeInterpolation]:
        """Crossings of the pairs on their edges: first of straight ones, then of segments."""
        i, j = (which[pairs] for which in self._edges)
        t, s = self._fractions(pairs, edge, face, frame)
        for _ in range(CROSSING_ROUNDS):
            (over, x), (under, y) = self.upper.locate(i, t), self.lower.locate(j, s)
            apart = self.lower.spots(under, y, face).carried(face)
            apart -= self.upper.spots(over, x, edge).carried(edge)
            ways = self.upper.tangents(over, x, edge), self.lower.tangents(under, y, face)
            dx, dy = _solved(frame[pairs], *ways, apart)
            x, y = x + dx, y + dy
            if max(np.abs(dx).max(), np.abs(dy).max()) < CROSSING_SETTLED:
                break
            t, s = self.upper.fraction(i, over, x), self.lower.fraction(j, under, y)
        return self.upper.spots(over, x, edge), self.lower.spots(under, y, face)

    def _for_all(self, pairs: Indices, spots: EdgeInterpolation) -> EdgeInterpolation:
        """The places of some pairs among those of all; the others have no weight."""
        k = spots.nodes.shape[1]
        nodes, weights = np.zeros((self.count, k), dtype=np.int64), np.zeros((self.count, k))
        segment, where = np.zeros(self.count, dtype=np.int64), np.zeros(self.count)
        nodes[pairs], weights[pairs] = spots.nodes, spots.weights
        segment[pairs], where[pairs] = spots.segment, spots.where
        return EdgeInterpolation(nodes, weights, segment, where, spots.position)

    def _moved(self, old: ContactKinematics, new: ContactKinematics) -> Array:
        """D: how far places on the upper edges moved over those on the lower ones, (count, 3)."""
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
        pairs = (old.own_projection, new.own_projection), (old.projection, new.projection)
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
        (a0, a1, _), (b0, b1, _) = self._increments(old, new)
        a, b = _way(self.upper, a0, a1, pressed), _way(self.lower, b0, b1, pressed)
        frames, given = new.frame[pressed], force[pressed]
        m = crossed(a, b)
        m /= np.sum(m * frames[:, 0], axis=1)[:, None]  # m = (a x b)/(n . (a x b))
        vectors[pressed] = given[:, :1] * m + in_space(given[:, 1:], frames[:, 1:])
        return vectors

    def frame(self, rotation: Array) -> Array:
        """Frames before any pair crosses, which turn with edges by `detect` alone."""
        return self.reference_frame

    def work_defect(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> float:
        """Zero: the work of the vectors is exact."""
        return 0.0

    def beyond_edge(self, kinematics: ContactKinematics) -> Mask | None:
        """Points beyond an edge: of the pairs that may touch there are none."""
        return None


def _solved(frame: Array, a: Array, b: Array, apart: Array) -> tuple[Array, Array]:
    """The x and y for which x a - y b is `apart` as seen along the normals; 0 if parallel."""
    (a0, a1), (b0, b1), (c0, c1) = (
        np.einsum("mij,mj->im", frame[:, 1:], vectors) for vectors in (a, b, apart)
    )
    area = b0 * a1 - a0 * b1
    area = np.where(area == 0, np.inf, area)
    return (b0 * c1 - b1 * c0) / area, (a0 * c1 - a1 * c0) / area


def crossed(a: Array, b: Array) -> Array:
    """Cross products of vectors in space, (..., 3); np.cross takes five times as long for few."""
    return a[..., NEXT] * b[..., LAST] - a[..., LAST] * b[..., NEXT]


def _way(
    outline: Outline, first: EdgeInterpolation, last: EdgeInterpolation, chosen: Indices
) -> Array:
    """The direction of dN . mean x on an edge, also where the place does not move.

    It is the chord from one place to the other where they are on two segments, else the tangent of
    the segment halfway, which is parallel to it.
    """
    mean_nodes = 0.5 * (first.position + last.position)
    begin, end = first.segment[chosen], last.segment[chosen]
    x, y = first.where[chosen], last.where[chosen]
    tangent = outline.tangents(begin, np.where(begin == end, 0.5 * (x + y), x), mean_nodes)
    chord = (last.carried(mean_nodes) - first.carried(mean_nodes))[chosen]
    moves = np.sum(chord**2, axis=1) > SHORT_WAY**2 * np.sum(tangent**2, axis=1)
    return np.where(((begin != end) & moves)[:, None], chord, tangent)


class CrossingInterface(Interface):
    """Kinematics and forces of the contact between the outlines of two faces."""

    def __init__(
        self,
        carrier: Crossings,
        law: FrictionSpec,
        *,
        bed: Bed | None = None,
        corner_area: float = 0.0,
    ):
        """Take the outlines that may cross; all else as `Interface`."""
        points, count = carrier.upper.points, carrier.count
        super().__init__(points, carrier, law, count=count, bed=bed, corner_area=corner_area)
        self.crossings = carrier

    def start(
        self, u: Array | None, carrier_u: Array | None, rotation: Array, carrier_rotation: Array
    ) -> Memory:
        """The memory of pairs without contact forces, with those that cross now."""
        surface, carried = self._placed(u, carrier_u)
        assert carried is not None
        here, frame = (surface.position, carried.position), self.crossings.reference_frame
        return self._begun(surface, *self.crossings.detect(surface.position, carried, here, frame))

    def observe(self, u: Array | None, carrier_u: Array | None, since: Memory) -> Observed:
        """The points, and the crossings of the pairs that cross in the step since a memory."""
        surface, carried = self._placed(u, carrier_u)
        start = since.kinematics
        return surface, self.crossings.kinematics(
            surface.position, carried, start.frame, since.may_touch, start
        )

    def prepare(self, memory: Memory, u: Array | None, carrier_u: Array | None) -> Memory:
        """The memory that the coming step starts from: which edges cross in it, and the frames.

        Args:
            memory: Of t_n.
            u: Unknowns of the upper body expected in the middle of the step.
            carrier_u: Those of the lower one.
        """
        upper, lower = self._placed(u, carrier_u)
        before = memory.kinematics
        assert before.carrier is not None and lower is not None
        kinematics, present = self.crossings.detect(
            memory.surface.position,
            before.carrier,
            (upper.position, lower.position),
            before.frame,
        )
        begun = memory._replace(kinematics=kinematics, anchor=np.zeros_like(memory.anchor))
        return begun.touching(present)

    def without_corners(
        self, memory: Memory, edge: Interface, corners: Memory
    ) -> tuple[Memory, Memory]:
        """The memories of crossings and of the lower outline, of which no two are at one place.

        Where an edge crosses another one at its end, and the corner there is over the upper face,
        the corner alone counts; where it is beyond that face's edge, the crossing alone. Forces at
        both would not be unique.

        Args:
            memory: Of the crossings, at the start of a step.
            edge: The interface of the points of the lower outline with the upper face.
            corners: Its memory.
        """
        there, foot = np.flatnonzero(memory.may_touch), memory.kinematics.projection
        if not len(there):
            return memory, corners
        assert isinstance(foot, EdgeInterpolation)
        numbers = self.crossings.lower.corners
        places = foot.carried(foot.position)[there]
        apart = np.linalg.norm(places[:, None] - corners.surface.position[numbers], axis=2)
        which, corner = np.nonzero(apart < self.crossings.one_place)
        if not len(which):
            return memory, corners
        beyond = edge.carrier.beyond_edge(corners.kinematics)
        assert beyond is not None
        off = beyond[numbers[corner]]
        left = corners.may_touch.copy()
        left[numbers[corner[off]]] = False
        stays = memory.may_touch.copy()
        stays[there[which[~off]]] = False
        return memory.touching(stays), corners.touching(left)

    def inside(self, memory: Memory) -> Mask:
        """Pairs that cross at this instant, not only at some time in its step."""
        kinematics = memory.kinematics
        assert kinematics.carrier is not None
        places = memory.surface.position, kinematics.carrier.position
        return self.crossings.within(*places, kinematics.frame, memory.may_touch)
