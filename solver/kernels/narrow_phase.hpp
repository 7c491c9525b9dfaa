// Where two convex bodies may touch: the corners of the overlap of the two faces that look at each
// other, or two edges that cross.
//
// Neither body is master. The first of a pair is taken as smaller by a hair (`inset`) in the plane of
// contact, only to decide which corners count: every corner of the overlap is then exactly one of a
// corner of a on b's face, a corner of b on a's face, or a crossing of two edges. Flush stacks,
// running bond and overhangs need no further rule.
#pragma once

#include <cstdint>

#include "shape.hpp"

namespace rockslip {

enum class Kind : std::uint8_t {
    CORNER_FACE,
    EDGE_EDGE,
    EDGE_FACE,  // where nearly parallel edges cross: a point of the one on the face of the other
};

/// A place where two bodies may touch: a point of body `point_body` and a face of `face_body`, or an
/// edge of each. Its identity lasts over steps.
template <int d> struct Feature {
    int point_body, face_body;
    Kind kind;
    int point;     // corner, or edge of `point_body`
    int face;      // face, or edge of `face_body`
    int other;     // of EDGE_FACE: the edge that crosses
    double sign;   // of EDGE_EDGE: of the normal against the product of both edges
    Vec<d> arm;    // the point in the frame of its body
    double area;   // that cohesion acts on, m2 (in the plane a length, m)
    int point_part = 0, face_part = 0;  // parts of both bodies

    /// Below 2^53, so that checkpoints hold it: 512 parts of a body, 65536 corners, edges and faces of a part.
    std::uint64_t id() const {
        const auto word = [](int number) { return static_cast<std::uint64_t>(number); };
        const std::uint64_t parts = (word(point_part) << 9) + word(face_part), order = word(point_body > face_body);
        return ((((parts * 6 + order * 3 + word(static_cast<int>(kind))) << 16) + word(point)) << 16) + word(kind == Kind::EDGE_FACE ? other : face);
    }
};

/// Two lines P + s u and Q + r v: the parameters of their closest points, the unit vector n across
/// both, and the distance along it.
struct Crossing {
    double s, r, gap;
    Vec<3> normal;
};

inline Crossing crossing(const Vec<3>& P, const Vec<3>& u, const Vec<3>& Q, const Vec<3>& v, double sign) {
    const Vec<3> across = cross(u, v), between = Q - P;
    const double squared = dot(across, across);
    const Vec<3> normal = (sign / std::sqrt(squared)) * across;
    return {dot(cross(between, v), across) / squared, dot(cross(between, u), across) / squared,
            -dot(normal, between), normal};
}

/// Edges whose sine is below this part no bodies, up to round-off.
constexpr double PARALLEL = 1e-6;

/// Sine of two edges of faces that lie on one another, below which their crossing is a point on a face:
/// the normal across both turns with their small angle.
constexpr double NEARLY_PARALLEL = 0.02;

/// Cosine to a face's normal above which a normal across two edges belongs to that face.
constexpr double ALONG_A_FACE = 0.98;

/// What two computations of one distance differ by, of `inset`.
constexpr double DISTANCE_ROUND_OFF = 1e-3;

/// Sine of the angle between faces above which they are not flush.
constexpr double OBLIQUE = 1e-3;

/// The narrow phase of one pair; a and b are the numbers of the bodies, a < b.
template <int d> class NarrowPhase {
  public:
    NarrowPhase(int a, int b, const Shape<d>& A, const Shape<d>& B, const PlacedShape<d>& at_a,
                const PlacedShape<d>& at_b, double margin, double inset, std::vector<Feature<d>>& found)
        : a_(a), b_(b), A_(A), B_(B), at_a_(at_a), at_b_(at_b), margin_(margin), inset_(inset), found_(found) {}

    /// Appends the features nearer than the margin; returns the distance of the bodies along the axis
    /// that separates them best (below 0: their overlap).
    double find() {
        if (A_.is_half_space()) return above(true);
        if (B_.is_half_space()) return above(false);
        const auto [face_a, outer_a, apart_a] = best_face(A_, at_a_, at_b_);
        if (apart_a > margin_) return apart_a;
        const auto [face_b, outer_b, apart_b] = best_face(B_, at_b_, at_a_);
        if (apart_b > margin_) return apart_b;
        const bool by_a = outer_a > outer_b;
        apart_ = std::max(apart_a, apart_b);
        within_ = apart_ > std::max(outer_a, outer_b);
        if constexpr (d == 3)
            if (by_edges()) return apart_;
        if (by_a) clip(face_a, facing(B_, at_b_, at_a_.normals[face_a]), true);
        else clip(facing(A_, at_a_, at_b_.normals[face_b]), face_b, false);
        if (hides_overlap()) deepest_corners(by_a, by_a ? face_a : face_b);
        return apart_;
    }

  private:
    double round_off() const { return DISTANCE_ROUND_OFF * inset_; }

    /// Whether bodies overlap by more than their features show: a corner on a corner is not over a face.
    bool hides_overlap() const { return !within_ && apart_ < round_off() && least_ > apart_ + round_off(); }

    /// Adds a feature if it is near, unless it shows an overlap of bodies that are apart.
    void add(const Feature<d>& feature, double gap) {
        if (gap >= margin_ || (apart_ > -round_off() && gap < std::min(apart_, 0.0) - round_off())) return;
        found_.push_back(feature);
        least_ = std::min(least_, gap);
    }

    /// All corners of a body over a half-space.
    double above(bool half_space_is_a) {
        const PlacedShape<d>&body = half_space_is_a ? at_b_ : at_a_, &ground = half_space_is_a ? at_a_ : at_b_;
        const Shape<d>& shape = half_space_is_a ? B_ : A_;
        if (shape.is_half_space()) return INFINITY;
        const Face<d>& down = shape.faces[facing(shape, body, ground.normals[0])];
        area_ = down.area / static_cast<double>(down.corners.size());
        double least = INFINITY;
        for (std::size_t i = 0; i < body.vertices.size(); i++)
            least = std::min(least, corner_on_face(!half_space_is_a, static_cast<int>(i), 0));
        return least;
    }

    /// Adds a corner of one body over a face of the other if it is near; returns its distance.
    double corner_on_face(bool corner_of_a, int corner, int face) {
        const PlacedShape<d>&own = corner_of_a ? at_a_ : at_b_, &other = corner_of_a ? at_b_ : at_a_;
        const double offset = (corner_of_a ? B_ : A_).faces[face].offset;
        const bool counts = (corner_of_a ? A_ : B_).is_corner(corner);
        const double gap = dot(other.normals[face], own.vertices[corner] - other.at.centre) - offset;
        if (counts)
            add({corner_of_a ? a_ : b_, corner_of_a ? b_ : a_, Kind::CORNER_FACE, corner, face, 0, 1,
                 (corner_of_a ? A_ : B_).vertices[corner], area_}, gap);
        return gap;
    }

    struct Parting {
        int face;
        double outer, apart;
    };

    /// The face of a shape whose plane is farthest from the other shape, that distance, and the largest of all
    /// faces: inner ones may part, but nothing touches them.
    Parting best_face(const Shape<d>& shape, const PlacedShape<d>& own, const PlacedShape<d>& other) const {
        int best = 0;
        double most = -INFINITY, apart = -INFINITY;
        for (std::size_t f = 0; f < shape.faces.size(); f++) {
            double least = INFINITY;
            const double level = dot(own.normals[f], own.at.centre) + shape.faces[f].offset;
            for (const Vec<d>& vertex : other.vertices) {
                least = std::min(least, dot(own.normals[f], vertex) - level);
                if (least <= most) break;
            }
            apart = std::max(apart, least);
            if (least > most && shape.is_surface(f)) {
                most = least;
                best = static_cast<int>(f);
            }
            if (apart > margin_) break;
        }
        return {best, most, apart};
    }

    /// The face that looks most against a direction.
    static int facing(const Shape<d>& shape, const PlacedShape<d>& placed, const Vec<d>& direction) {
        int best = 0;
        double least = INFINITY;
        for (std::size_t f = 0; f < placed.normals.size(); f++) {
            if (!shape.is_surface(f)) continue;
            const double cosine = dot(placed.normals[f], direction);
            if (cosine < least) {
                least = cosine;
                best = static_cast<int>(f);
            }
        }
        return best;
    }

    /// Adds the corner that is deepest below a face, and those as deep up to round-off: the ends of an
    /// edge that passes over an edge, the corners of a face.
    void deepest_corners(bool by_a, int face) {
        const PlacedShape<d>& other = by_a ? at_b_ : at_a_;
        const Vec<d>& normal = (by_a ? at_a_ : at_b_).normals[face];
        double deepest = INFINITY;
        for (const Vec<d>& vertex : other.vertices) deepest = std::min(deepest, dot(normal, vertex));
        for (std::size_t i = 0; i < other.vertices.size(); i++)
            if (dot(normal, other.vertices[i]) <= deepest + round_off()) corner_on_face(!by_a, static_cast<int>(i), face);
    }

    /// By how much a's face is taken as smaller. Of oblique faces the one whose normal counts is taken as
    /// larger instead: a corner beside it is as far from the other body as from its plane, whereas a corner
    /// beside the tilted face is not.
    double hair(int face_a, int face_b, bool by_a) const {
        const Vec<d>&m = at_a_.normals[face_a], &n = at_b_.normals[face_b];
        return by_a && norm(m + n) > OBLIQUE ? -inset_ : inset_;
    }

    /// The ends of the overlap of two edges of polygons.
    void clip(int face_a, int face_b, bool by_a) {
        if constexpr (d == 3) {
            clip_polygons(face_a, face_b, by_a);
        } else {
            const Vec<2> n = by_a ? at_a_.normals[face_a] : at_b_.normals[face_b], t{-n[1], n[0]};
            struct End {
                double s;
                bool of_a;
                int corner;
            };
            const auto ends = [&](const PlacedShape<2>& placed, const std::vector<int>& corners, bool of_a, double inset) {
                std::array<End, 2> e{{{dot(t, placed.vertices[corners[0]]), of_a, corners[0]},
                                      {dot(t, placed.vertices[corners[1]]), of_a, corners[1]}}};
                if (e[0].s > e[1].s) std::swap(e[0], e[1]);
                e[0].s += inset;
                e[1].s -= inset;
                return e;
            };
            const auto of_a = ends(at_a_, A_.faces[face_a].corners, true, hair(face_a, face_b, by_a));
            const auto of_b = ends(at_b_, B_.faces[face_b].corners, false, 0);
            const End low = of_a[0].s > of_b[0].s ? of_a[0] : of_b[0], high = of_a[1].s < of_b[1].s ? of_a[1] : of_b[1];
            if (low.s > high.s) return;
            area_ = 0.5 * (high.s - low.s);
            for (const End& end : {low, high}) corner_on_face(end.of_a, end.corner, end.of_a ? face_b : face_a);
        }
    }

    // ---------------------------------------------------------------- in space

    /// Whether two edges separate the bodies better than their faces: then `apart_` is their distance, and
    /// the features are added.
    ///
    /// Edges whose arcs on the sphere of normals cross make a face of the difference of both bodies
    /// (Gregorius 2013); only these can separate.
    bool by_edges() {
        double most = -INFINITY;
        int edge_a = -1, edge_b = -1;
        Vec<3> axis{};
        for (std::size_t i = 0; i < A_.edges.size(); i++) {
            const Edge& x = A_.edges[i];
            if (x.inner) continue;
            const Vec<3> u = at_a_.vertices[x.to] - at_a_.vertices[x.from];
            const Vec<3>&a0 = at_a_.normals[x.left], &a1 = at_a_.normals[x.right];
            for (std::size_t j = 0; j < B_.edges.size(); j++) {
                const Edge& y = B_.edges[j];
                if (y.inner) continue;
                const Vec<3>&b0 = at_b_.normals[y.left], &b1 = at_b_.normals[y.right];
                const double c = -dot(b0, u), e = -dot(b1, u);
                if (!(c * e < 0)) continue;
                const Vec<3> v = at_b_.vertices[y.to] - at_b_.vertices[y.from];
                const double f = dot(a0, v), g = dot(a1, v);
                if (!(f * g < 0 && c * g > 0)) continue;
                const Vec<3> across = cross(u, v);
                const double length = norm(across);
                if (length < PARALLEL * norm(u) * norm(v)) continue;
                Vec<3> n = (1 / length) * across;
                if (dot(n, a0 + a1) > 0) n = -1.0 * n;  // from b to a
                if (dot(n, b0 + b1) < 0) continue;
                const double distance = dot(n, at_a_.vertices[x.from] - at_b_.vertices[y.from]);
                if (distance > most) {
                    most = distance;
                    edge_a = static_cast<int>(i);
                    edge_b = static_cast<int>(j);
                    axis = n;
                }
            }
        }
        if (edge_a < 0 || most <= apart_ + 1e-9 * A_.radius) return false;
        apart_ = most;
        if (most > margin_) return true;
        const int near_a = facing(A_, at_a_, axis), near_b = facing(B_, at_b_, -1.0 * axis);
        const double along_a = -dot(axis, at_a_.normals[near_a]), along_b = dot(axis, at_b_.normals[near_b]);
        const std::size_t before = found_.size();
        if (std::max(along_a, along_b) >= ALONG_A_FACE) clip_polygons(near_a, near_b, along_a > along_b);
        // The faces beside the edges need not lie over each other where the edges cross.
        if (found_.size() == before || hides_overlap()) edge_edge(edge_a, edge_b, axis, -1);
        return true;
    }

    /// Adds the crossing of two edges; nearly parallel ones as a point on a face of b, if there is one.
    void edge_edge(int edge_a, int edge_b, const Vec<3>& up, int face_b) {
        const Edge &x = A_.edges[edge_a], &y = B_.edges[edge_b];
        if (x.inner || y.inner) return;
        const Vec<3> P = at_a_.vertices[x.from], u = at_a_.vertices[x.to] - P;
        const Vec<3> Q = at_b_.vertices[y.from], v = at_b_.vertices[y.to] - Q, across = cross(u, v);
        if (norm(across) > (face_b < 0 ? PARALLEL : NEARLY_PARALLEL) * norm(u) * norm(v)) {
            const double sign = dot(across, up) > 0 ? 1 : -1;
            const Crossing found = crossing(P, u, Q, v, sign);
            if (dot(found.normal, up) > 0.5) {
                add({a_, b_, Kind::EDGE_EDGE, edge_a, edge_b, 0, sign, {}, area_}, found.gap);
                return;
            }
        }
        if (face_b < 0) return;
        const Vec<3> beside = cross(up, v);  // a's edge passes over b's where this has no component
        const double rate = dot(beside, u);
        if (std::fabs(rate) < 1e-14 * norm(u) * norm(v)) return;
        const double s = std::clamp(dot(beside, Q - P) / rate, 0.0, 1.0);
        const double gap = dot(at_b_.normals[face_b], P + s * u - at_b_.at.centre) - B_.faces[face_b].offset;
        add({a_, b_, Kind::EDGE_FACE, edge_a, face_b, edge_b, 1,
             A_.vertices[x.from] + s * (A_.vertices[x.to] - A_.vertices[x.from]), area_}, gap);
    }

    /// The corners of the overlap of two faces, seen along the normal of one of them.
    void clip_polygons(int number_a, int number_b, bool by_a) {
        const Face<3>&face_a = A_.faces[number_a], &face_b = B_.faces[number_b];
        const Vec<3> up = by_a ? -1.0 * at_a_.normals[number_a] : at_b_.normals[number_b];  // from b to a
        const Vec<3> t0 = mul(by_a ? at_a_.at.R : at_b_.at.R, (by_a ? face_a : face_b).tangent[0]), t1 = cross(up, t0);
        const auto plan = [&](const Vec<3>& x) { return Vec<2>{dot(t0, x), dot(t1, x)}; };
        const double shrunk = hair(number_a, number_b, by_a);
        const int na = static_cast<int>(face_a.corners.size()), nb = static_cast<int>(face_b.corners.size());
        static thread_local std::vector<Vec<2>> a, b, inner;
        a.resize(na);
        b.resize(nb);
        inner.resize(na);
        // a's face looks down: turned round, both run anticlockwise.
        for (int k = 0; k < na; k++) a[k] = plan(at_a_.vertices[face_a.corners[na - 1 - k]]);
        for (int k = 0; k < nb; k++) b[k] = plan(at_b_.vertices[face_b.corners[k]]);
        const auto left_of = [](const Vec<2>& p, const Vec<2>& q, const Vec<2>& r) {
            return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        };
        for (int k = 0; k < na; k++) {
            const Vec<2> next = a[(k + 1) % na] - a[k], last = a[k] - a[(k + na - 1) % na];
            const double ln = norm(next), ll = norm(last);
            const double sine = (last[0] * next[1] - last[1] * next[0]) / (ln * ll);
            const double room = std::fabs(sine) < 1e-6 ? 1e-6 : sine;
            inner[k] = a[k] + (shrunk / room) * ((1 / ln) * next - (1 / ll) * last);
        }
        const auto corner_of_a = [&](int k) { return face_a.corners[na - 1 - k]; };
        const auto edge_of_a = [&](int k) { return face_a.edges[(2 * na - 2 - k) % na]; };  // k to k + 1
        const std::size_t before = found_.size();
        for (int k = 0; k < na; k++) {
            bool inside = true;
            for (int j = 0; j < nb; j++) inside &= left_of(b[j], b[(j + 1) % nb], inner[k]) >= 0;
            if (inside) corner_on_face(true, corner_of_a(k), number_b);
        }
        for (int k = 0; k < nb; k++) {
            bool inside = true;
            for (int j = 0; j < na; j++) inside &= left_of(inner[j], inner[(j + 1) % na], b[k]) >= 0;
            if (inside) corner_on_face(false, face_b.corners[k], number_a);
        }
        for (int i = 0; i < na; i++)
            for (int j = 0; j < nb; j++) {
                const Vec<2>&p0 = inner[i], &p1 = inner[(i + 1) % na], &q0 = b[j], &q1 = b[(j + 1) % nb];
                const bool parted = (left_of(p0, p1, q0) >= 0) != (left_of(p0, p1, q1) >= 0);
                const bool parting = (left_of(q0, q1, p0) >= 0) != (left_of(q0, q1, p1) >= 0);
                if (parted && parting) edge_edge(edge_of_a(i), face_b.edges[j], up, number_b);
            }
        share_area(before, inner, b);
    }

    /// Gives each new feature its share of the area that two convex polygons have in common.
    void share_area(std::size_t first, const std::vector<Vec<2>>& one, const std::vector<Vec<2>>& other) {
        if (found_.size() == first) return;
        static thread_local std::vector<Vec<2>> rest, cut;  // Sutherland and Hodgman (1974)
        rest = one;
        const std::size_t sides = other.size();
        for (std::size_t j = 0; j < sides && !rest.empty(); j++) {
            const Vec<2>&p = other[j], q = other[(j + 1) % sides];
            const auto depth = [&](const Vec<2>& x) { return (q[0] - p[0]) * (x[1] - p[1]) - (q[1] - p[1]) * (x[0] - p[0]); };
            cut.clear();
            for (std::size_t k = 0; k < rest.size(); k++) {
                const Vec<2>&x = rest[k], &y = rest[(k + 1) % rest.size()];
                const double dx = depth(x), dy = depth(y);
                if (dx >= 0) cut.push_back(x);
                if ((dx >= 0) != (dy >= 0)) cut.push_back(x + (dx / (dx - dy)) * (y - x));
            }
            rest.swap(cut);
        }
        double area = 0;
        for (std::size_t k = 2; k < rest.size(); k++) {
            const Vec<2> u = rest[k - 1] - rest[0], v = rest[k] - rest[0];
            area += 0.5 * (u[0] * v[1] - u[1] * v[0]);
        }
        const double share = area / static_cast<double>(found_.size() - first);
        for (std::size_t i = first; i < found_.size(); i++) found_[i].area = share;
    }

    int a_, b_;
    const Shape<d>&A_, &B_;
    const PlacedShape<d>&at_a_, &at_b_;
    double margin_, inset_;
    std::vector<Feature<d>>& found_;
    double area_ = 0;
    double apart_ = -INFINITY;  // along the axis that separates the bodies best so far
    double least_ = INFINITY;   // gap of the features
    bool within_ = false;       // an inner face parts the bodies best: this tells nothing of their overlap
};

}  // namespace rockslip
