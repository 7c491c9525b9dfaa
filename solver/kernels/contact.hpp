// Contacts and their rows.
//
// Rows G with G du = change of (gap, place along the face) in a step, exactly, and balanced forces.
// With Cayley vectors psi and means over both ends (index m), products change by
// d(n.p) = n_m.dp + dn.p_m. For a point p of body a and a face of body b, and each axis e = n, t of
// that face,
//
//     d(e.(p - x_b)) = e_m.(dx_a - dx_b) + psi_a.(arm_m x e_m) - psi_b.((p_m - x_b,m) x e_m):   (M53)
//
// forces along such rows have no resultant and no moment, and do exactly f.d(...) of work. Two edges
// with directions u and v have m = u_m x v_m / (n_{n+1}.(u_m x v_m)) in place of e_m ((M30) to
// (M33)).
#pragma once

#include "body.hpp"
#include "friction.hpp"
#include "link.hpp"
#include "narrow_phase.hpp"

namespace rockslip {

/// A place where two bodies touch or may touch in a step, or a link: rows, impulses, and what friction does.
template <int d> struct Contact {
    Feature<d> feature;
    std::uint64_t id;
    int a, b;              // numbers of the bodies among those of the island; -1: fixed
    bool free_point;       // whether the body of the point moves freely: rows on a platform lack a direction
    const ContactLaw* law;
    const LinkStep<d>* link = nullptr;  // of a link, which stands among contacts in the local problem
    double gap;            // at the start of the step, m
    Vec<d> start{};        // gap and place along the face at the start, as remembered, m
    bool was_closed = false;  // in the step before
    double area;           // that cohesion acts on, m2
    FrictionHistory past;
    FrictionBound bound;
    FrictionMode mode = FrictionMode::LAW;
    Vec<d> given{};        // friction that is given, or its direction

    Mat<d, Dim<d>::unknowns> rows_a, rows_b;
    Vec<d> constant;       // y = constant + rows_a w_a + rows_b w_b
    Vec<d> impulse{};      // P
    Vec<d> anchor;         // impulse that the proximal term holds
    Vec<d> y;
    Vec<d> velocity_impulse{};
    Vec<d> total{};        // all impulses of the step, velocity level and impacts included
    State state = OPEN;
    bool slips = false;
    bool closed = false;   // at the end of the step
    double lost;           // energy that the contact took in the step, J
    double rubbed;         // and its friction, J
    double end_gap;        // m

    /// The normal, from the body of the face to that of the point, or a tangent.
    Vec<d> axis(int number) const {
        Vec<d> e;
        for (int j = 0; j < d; j++) e[j] = free_point ? rows_a[number][j] : -rows_b[number][j];
        return e;
    }
};

/// A line along an edge of a body at a place: a point of it, and the way along the edge.
struct EdgeLine {
    Vec<3> from, along;

    EdgeLine(const Shape<3>& shape, int edge, const Placement<3>& at)
        : from(at.centre + mul(at.R, shape.vertices[shape.edges[edge].from])),
          along(mul(at.R, shape.vertices[shape.edges[edge].to] - shape.vertices[shape.edges[edge].from])) {}
};

/// Distance of a feature for bodies at two places.
template <int d>
double gap_of(const Feature<d>& feature, const Shape<d>& A, const Shape<d>& B, const Placement<d>& a, const Placement<d>& b) {
    if constexpr (d == 3)
        if (feature.kind == Kind::EDGE_EDGE) {
            const EdgeLine x(A, feature.point, a), y(B, feature.face, b);
            return crossing(x.from, x.along, y.from, y.along, feature.sign).gap;
        }
    const Face<d>& face = B.faces[feature.face];
    return dot(mul(b.R, face.normal), (a.centre - b.centre) + mul(a.R, feature.arm)) - face.offset;
}

/// Where a feature is for bodies at two places, in space.
template <int d>
Vec<d> place_of(const Feature<d>& feature, const Shape<d>& A, const Shape<d>& B, const Placement<d>& a, const Placement<d>& b) {
    if constexpr (d == 3)
        if (feature.kind == Kind::EDGE_EDGE) {
            const EdgeLine x(A, feature.point, a), y(B, feature.face, b);
            return x.from + crossing(x.from, x.along, y.from, y.along, feature.sign).s * x.along;
        }
    return a.centre + mul(a.R, feature.arm);
}

template <int d> void put_row(Contact<d>& k, int row, const Vec<d>& e, const Vec<d>& arm, const Vec<d>& back) {
    const auto turn_a = moment(arm, e), turn_b = moment(back, e);
    for (int i = 0; i < d; i++) {
        k.rows_a[row][i] = e[i];
        k.rows_b[row][i] = -e[i];
    }
    for (int i = 0; i < Dim<d>::rotations; i++) {
        k.rows_a[row][d + i] = turn_a[i];
        k.rows_b[row][d + i] = -turn_b[i];
    }
}

/// Takes the unknowns that a platform does not have out of rows on it.
template <int d> void restrict_to_platform(Mat<d, Dim<d>::unknowns>& rows) {
    for (auto& row : rows)
        for (int i = d - 1; i < Dim<d>::unknowns; i++) row[i] = 0;
}

/// Writes the rows for motions from places a0, b0 to a1, b1, and y at the start.
template <int d>
void write_contact_rows(Contact<d>& k, const Shape<d>& A, const Shape<d>& B, const Placement<d>& a0, const Placement<d>& a1,
                const Placement<d>& b0, const Placement<d>& b1) {
    const Mat<d, d> Ra = mean(a0.R, a1.R), Rb = mean(b0.R, b1.R);
    const Vec<d> apart = 0.5 * ((a0.centre - b0.centre) + (a1.centre - b1.centre));
    k.constant = k.start;
    if constexpr (d == 3)
        if (k.feature.kind == Kind::EDGE_EDGE) {
            const Edge &x = A.edges[k.feature.point], &y = B.edges[k.feature.face];
            const Vec<3> p = A.vertices[x.from], u = A.vertices[x.to] - p;
            const Vec<3> q = B.vertices[y.from], v = B.vertices[y.to] - q;
            const auto at = [&](const Placement<3>& a, const Placement<3>& b) {
                return crossing((a.centre - b.centre) + mul(a.R, p), mul(a.R, u), mul(b.R, q), mul(b.R, v), k.feature.sign);
            };
            const Crossing first = at(a0, b0), last = at(a1, b1);
            const Vec<3> um = mul(Ra, u), across = cross(um, mul(Rb, v)), m = (1 / dot(last.normal, across)) * across;
            Vec<3> t0 = um - (dot(um, m) / dot(m, m)) * m;
            t0 = (1 / norm(t0)) * t0;
            const Vec<3> t1 = cross((1 / norm(m)) * m, t0);
            const Vec<3> arm = mul(Ra, p + (0.5 * (first.s + last.s)) * u), back = mul(Rb, q + (0.5 * (first.r + last.r)) * v);
            put_row(k, 0, m, arm, back);
            // Friction acts at one point of both, so that it has no moment.
            put_row(k, 1, t0, arm, apart + arm);
            put_row(k, 2, t1, arm, apart + arm);
            k.constant[0] *= dot(first.normal, m);
            return;
        }
    const Face<d>& face = B.faces[k.feature.face];
    const Vec<d> arm = mul(Ra, k.feature.arm), back = apart + arm;
    put_row(k, 0, mul(Rb, face.normal), arm, back);
    for (int i = 0; i + 1 < d; i++) put_row(k, 1 + i, mul(Rb, face.tangent[i]), arm, back);
}

/// Writes the rows of a link for motions from places a0, b0 to a1, b1: y is its rate of extension.
///
/// With r the line between the ends, d|r| = r_m.dr / (|r_0| + |r_1|)/2 exactly; along axes of the first body
/// as (M53).
template <int d>
void write_link_rows(Contact<d>& k, const Placement<d>& a0, const Placement<d>& a1, const Placement<d>& b0, const Placement<d>& b1) {
    const Link<d>& link = *k.link->link;
    const Mat<d, d> Ra = mean(a0.R, a1.R), Rb = mean(b0.R, b1.R);
    const Vec<d> arm = mul(Rb, link.end_b), foot = mul(Ra, link.end_a);
    const Vec<d> apart = 0.5 * ((b0.centre - a0.centre) + (b1.centre - a1.centre));
    k.constant.fill(0);
    k.rows_a = k.rows_b = {};
    if (link.axial) {
        const double lengths = 2 * link.length[0] + link.measure(a0, b0)[0] + link.measure(a1, b1)[0];
        put_row(k, 0, (2 / lengths) * (apart + arm - foot), arm, foot);
        return;
    }
    for (int i = 0; i < d; i++) put_row(k, i, mul(Ra, link.axes[i]), arm, apart + arm);
}

}  // namespace rockslip
