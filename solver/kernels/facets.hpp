// Closest points on the facets of a face, and what follows from how they move.
//
// With the shape functions N at the closest points before and after a step, the nodes x_c of the face,
// the frame (n, t) of the step, bars for means and d for increments over the step (docs/method.md,
// (M27) to (M29)),
//
//     e = dN . mean x_c = (e_n, e_t)                increment of the closest point on the mean surface
//     dg = (n - kappa t) . (dx - mean N dx_c),      kappa = e_n/e_t        the mean slope
//     ds = (t/a) . (dx - mean N dx_c),              a = e_t/ds             the mean stretch
//
// hold exactly, whatever the step and however many facets it crosses.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "small_arrays.hpp"

namespace rockslip {

/// Part of a facet: as near as this to its edge, the slope at a closest point goes over to the mean of the
/// facets that meet there.
constexpr double EDGE_BLEND_WIDTH = 0.02;

/// Part of a facet: Newton's method for a closest point ends when it moves it by less; the rest is the
/// square of that.
constexpr double PROJECTION_TOLERANCE = 1e-12;

/// Corrections of Newton's method for a closest point, at most.
constexpr int PROJECTION_ITERATIONS = 4;

/// Facets around a point, the nearest ones first, that are searched for its closest point.
constexpr int FACETS_TRIED = 4;

/// Part of a facet: one that is farther than the nearest one by more is not tried.
///
/// Taken as spanned by two edges, a facet misses points on it by no more than its last corner is off the
/// parallelogram of the others: by strains, a few per cent of a facet.
constexpr double FARTHER = 0.5;

/// Part of a facet: a closest point that moves by less has the local slope and stretch, one that moves by
/// twice as much or more those of its increment; in between there is a transition.
constexpr double STANDING_STILL = 1e-4;

/// Nodes of a facet at most, and the highest power of a coordinate: those of a quadratic quadrilateral.
constexpr int MOST_NODES = 9, HIGHEST_POWER = 2;

/// The inverse of a matrix; not numbers where there is none.
inline Mat<1, 1> inverted(const Mat<1, 1>& matrix) { return {{{1 / matrix[0][0]}}}; }
inline Mat<2, 2> inverted(const Mat<2, 2>& matrix) {
    const double determinant = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
    return {{{matrix[1][1] / determinant, -matrix[0][1] / determinant},
             {-matrix[1][0] / determinant, matrix[0][0] / determinant}}};
}

/// The facets of a face, whose shape functions are sums of monomials of t = d - 1 coordinates.
struct FacetShapes {
    Indices<2> facets;     // nodes of each facet, (facets, k)
    Indices<2> powers;     // of the coordinates in the monomials, (k, t)
    Array<2> factors;      // of the monomials in each shape function, (k, k)
    Array<3> derivatives;  // of the shape functions at a facet's own nodes, (k, t, k)
    Array<4> undeformed;   // inverses of the derivatives of undeformed tangential positions at each
                           // facet's nodes, (facets, k, t, t), 1/m
    Indices<2> meeting;    // facets that meet at nodes, and which of a facet's nodes that is, node after node
    Indices<1> first;      // number of the first of them at each node, and of all, (n + 1,)
    Array<2> along;        // tangential positions of the nodes in the undeformed face, (n, t), m
    std::int64_t corners;  // of a facet: 2 for intervals, 3 for triangles, 4 for quadrilaterals
    double margin;         // part of a facet by which points may be beyond its edge
};

/// Closest points of m points on the facets of a face, to be filled in.
struct ClosestPoints {
    IndicesOut<2> nodes;     // of the facet, (m, k)
    Output<2> weights;       // shape functions N of these there, (m, k)
    Output<2> slope;         // rise of the face along the tangents of the frame, (m, t); blended with that of
                             // the next facet where facets meet, so that it is continuous
    Output<3> stretch;       // current over undeformed tangential lengths, likewise, (m, t, t)
    MaskOut<1> beyond_edge;  // points beyond the edge of the face by more than its margin, (m,)
};

/// Rise of a face along the tangents of its frame, and current over undeformed tangential lengths.
template <int t> struct SlopeAndStretch {
    Vec<t> slope{};
    Mat<t, t> stretch{};

    void add(double factor, const SlopeAndStretch& other) {
        for (int i = 0; i < t; i++) {
            slope[i] += factor * other.slope[i];
            for (int j = 0; j < t; j++) stretch[i][j] += factor * other.stretch[i][j];
        }
    }

    /// Applies an operation to all numbers.
    template <class F> void each(F change) {
        for (double& number : slope) change(number);
        for (Vec<t>& row : stretch)
            for (double& number : row) change(number);
    }
};

/// Finds the closest points on a face, as its nodes are placed now.
template <int d> class FacetProjection {
  public:
    static constexpr int t = d - 1;

    /// Takes positions of the nodes in space (n, d), m, and the rows normal and tangents of a frame.
    FacetProjection(const FacetShapes& shapes, const Array<2>& carrier, const Mat<d, d>& frame)
        : shapes_(shapes), k_(static_cast<int>(shapes.facets.length(1))), is_triangle_(shapes.corners == 3) {
        if (k_ > MOST_NODES || shapes.powers.length(1) != t || (shapes.corners == 2) != (d == 2))
            throw std::invalid_argument("facets are not those of this dimension");
        for (const std::int64_t power : shapes.powers)
            if (power < 0 || power > HIGHEST_POWER) throw std::invalid_argument("facets are not linear or quadratic");
        for (int c = 0; c < k_; c++)
            for (int k = 0; k < k_; k++) factors_[c][k] = shapes.factors(k, c);
        placed_.resize(carrier.length());
        for (std::ptrdiff_t n = 0; n < carrier.length(); n++) placed_[n] = mul(frame, vector_at<d>(&carrier(n, 0)));
        if constexpr (d == 3) span();
    }

    /// Fills in gap and tangential position (g, s), m, of a point, m in the frame, and its closest point.
    void project(const Vec<d>& position, std::ptrdiff_t number, const Output<1>& place, const ClosestPoints& closest) {
        Vec<t> point, where{};
        for (int i = 0; i < t; i++) point[i] = position[1 + i];
        const int facet = over(point, where);
        const std::int64_t* nodes = nodes_of(facet);
        const Evaluated at = evaluate(where);
        std::copy_n(nodes, k_, &closest.nodes(number, 0));
        std::copy_n(at.values.begin(), k_, &closest.weights(number, 0));
        Vec<d> found{position[0]};
        Mat<t, t> along{};
        for (int a = 0; a < k_; a++) {
            const double* undeformed = &shapes_.along(nodes[a], 0);
            found[0] -= at.values[a] * placed_[nodes[a]][0];
            for (int i = 0; i < t; i++) {
                found[1 + i] += at.values[a] * undeformed[i];
                for (int j = 0; j < t; j++) along[i][j] += at.derivatives[j][a] * undeformed[i];
            }
        }
        fill_in(place, found);
        const double miss = outside_by(where);
        closest.beyond_edge[number] = miss > shapes_.margin && !(miss <= 0 && is_between_facets(nodes, where, at));
        SlopeAndStretch<t> there = slope_and_stretch(
            nodes, [&](int j, int a) { return at.derivatives[j][a]; }, inverted(along));
        const double share = std::min(std::max(1.0 + miss / EDGE_BLEND_WIDTH, 0.0), 1.0);
        if (share > 0) {
            there.each([&](double& each) { each *= 1 - share; });
            for (int a = 0; a < k_; a++) there.add(share * at.values[a], average_at(nodes[a]));
        }
        fill_in(closest.slope[number], there.slope);
        fill_in(closest.stretch[number], there.stretch);
    }

  private:
    /// Shape functions and their derivatives at coordinates on a facet.
    struct Evaluated {
        std::array<double, MOST_NODES> values;
        std::array<std::array<double, MOST_NODES>, t> derivatives;
    };

    /// A facet taken as spanned by edges from its first corner: that corner, m, and the inverse of the edges.
    struct Spanned {
        Vec<t> corner;
        Mat<t, t> inverse;

        Vec<t> coordinates(const Vec<t>& point) const { return mul(inverse, point - corner); }
    };

    /// Memory that is kept between calls.
    template <class T> static std::vector<T>& room() {
        static thread_local std::vector<T> kept;
        return kept;
    }

    const std::int64_t* nodes_of(std::ptrdiff_t facet) const { return &shapes_.facets(facet, 0); }

    Evaluated evaluate(const Vec<t>& where) const {
        std::array<Vec<HIGHEST_POWER + 1>, t> powers;
        for (int j = 0; j < t; j++) {
            powers[j][0] = 1;
            for (int e = 0; e < HIGHEST_POWER; e++) powers[j][e + 1] = powers[j][e] * where[j];
        }
        Evaluated at{};
        const std::int64_t* power = shapes_.powers.data();
        for (int c = 0; c < k_; c++, power += t) {
            double monomial = 1;
            for (int j = 0; j < t; j++) monomial *= powers[j][power[j]];
            for (int k = 0; k < k_; k++) at.values[k] += factors_[c][k] * monomial;
            for (int j = 0; j < t; j++) {
                if (power[j] == 0) continue;
                double slope = static_cast<double>(power[j]) * powers[j][power[j] - 1];
                for (int i = 0; i < t; i++)
                    if (i != j) slope *= powers[i][power[i]];
                for (int k = 0; k < k_; k++) at.derivatives[j][k] += factors_[c][k] * slope;
            }
        }
        return at;
    }

    /// Rise and stretch of a facet over its tangential coordinates.
    ///
    /// `derivative(j, a)` is that of the shape function of its node a along coordinate j, `undeformed` the
    /// inverse of the derivatives of the undeformed tangential positions, 1/m.
    template <class Derivative>
    SlopeAndStretch<t> slope_and_stretch(const std::int64_t* nodes, Derivative derivative,
                                         const Mat<t, t>& undeformed) const {
        Vec<t> rise{};
        Mat<t, t> flat{};
        for (int a = 0; a < k_; a++) {
            const Vec<d>& node = placed_[nodes[a]];
            for (int j = 0; j < t; j++) {
                rise[j] += derivative(j, a) * node[0];
                for (int i = 0; i < t; i++) flat[i][j] += derivative(j, a) * node[1 + i];
            }
        }
        SlopeAndStretch<t> found{transposed_mul(inverted(flat), rise), {}};
        add_product(found.stretch, flat, undeformed, 1);
        return found;
    }

    /// Slope and stretch at a node: means of the facets that meet there.
    SlopeAndStretch<t> average_at(std::int64_t node) const {
        SlopeAndStretch<t> mean;
        const std::int64_t begin = shapes_.first[node], end = shapes_.first[node + 1];
        for (std::int64_t m = begin; m < end; m++) {
            const std::int64_t facet = shapes_.meeting(m, 0), corner = shapes_.meeting(m, 1);
            const double* derivatives = &shapes_.derivatives(corner, 0, 0);
            const int k = k_;
            mean.add(1, slope_and_stretch(
                            nodes_of(facet), [=](int j, int a) { return derivatives[j * k + a]; },
                            matrix_in<t, t>(shapes_.undeformed[facet][corner])));
        }
        const double count = static_cast<double>(std::max<std::int64_t>(end - begin, 1));
        mean.each([&](double& number) { number /= count; });
        return mean;
    }

    /// Distance of a point outside of a facet, in its own coordinates; negative inside.
    double outside_by(const Vec<t>& where) const {
        double total = 0, miss = -INFINITY;
        for (int j = 0; j < t; j++) {
            total += where[j];
            miss = std::max(miss, -where[j]);
            if (!is_triangle_) miss = std::max(miss, where[j] - 1);
        }
        return is_triangle_ ? std::max(miss, total - 1) : miss;
    }

    /// True if a point on a side of its facet has another facet beyond it, and is at none of their nodes: there
    /// the node is the point of contact.
    bool is_between_facets(const std::int64_t* nodes, const Vec<t>& where, const Evaluated& at) const {
        const double shift = 8 * std::fabs(shapes_.margin), middle = is_triangle_ ? 1.0 / 3 : 0.5;
        if (*std::max_element(at.values.begin(), at.values.begin() + k_) > 1 - shift) return false;
        Vec<t> outwards = where, point{}, there{};
        for (double& coordinate : outwards) coordinate += shift * (coordinate - middle);
        const Evaluated further = evaluate(outwards);
        for (int a = 0; a < k_; a++)
            for (int i = 0; i < t; i++) point[i] += further.values[a] * placed_[nodes[a]][1 + i];
        over(point, there);
        return outside_by(there) <= 0;
    }

    /// Takes all facets as spanned by two edges.
    void span() {
        spanned_.resize(shapes_.facets.length());
        for (std::size_t facet = 0; facet < spanned_.size(); facet++) {
            const std::int64_t* nodes = nodes_of(static_cast<std::ptrdiff_t>(facet));
            const Vec<d>& corner = placed_[nodes[0]];
            Mat<t, t> edges;
            for (int i = 0; i < t; i++) {
                spanned_[facet].corner[i] = corner[1 + i];
                for (int j = 0; j < t; j++) edges[i][j] = placed_[nodes[1 + j]][1 + i] - corner[1 + i];
            }
            spanned_[facet].inverse = inverted(edges);
        }
    }

    /// Lets coordinates on a facet become those of a point, by Newton's method.
    void settle_on(int facet, const Vec<t>& point, Vec<t>& where) const {
        const std::int64_t* nodes = nodes_of(facet);
        for (int iteration = 0; iteration < PROJECTION_ITERATIONS; iteration++) {
            const Evaluated at = evaluate(where);
            Mat<t, t> gradient{};
            Vec<t> miss = point;
            for (int a = 0; a < k_; a++) {
                const Vec<d>& node = placed_[nodes[a]];
                for (int i = 0; i < t; i++) {
                    miss[i] -= at.values[a] * node[1 + i];
                    for (int j = 0; j < t; j++) gradient[i][j] += at.derivatives[j][a] * node[1 + i];
                }
            }
            const Vec<t> change = mul(inverted(gradient), miss);
            double largest = 0;
            for (const double each : change) largest = std::max(largest, std::fabs(each));
            where += change;
            if (largest < PROJECTION_TOLERANCE) break;
        }
    }

    /// The facet that a point is on or nearest to, with its coordinates there filled in.
    int over(const Vec<t>& point, Vec<t>& where) const {
        if constexpr (d == 2) return facet_under(point, where);
        else return nearest_facet(point, where);
    }

    /// The facet of chains in the plane that a point is over or nearest to, its coordinate there filled in.
    int facet_under(const Vec<1>& point, Vec<1>& where) const {
        const int last = static_cast<int>(shapes_.facets.length()) - 1;
        int facet = 0;
        while (facet < last && placed_[shapes_.facets(facet + 1, 0)][1] <= point[0]) facet++;
        if (facet < last) {  // between two pieces of a face the nearer one
            const double end = placed_[shapes_.facets(facet, 1)][1];
            const double next = placed_[shapes_.facets(facet + 1, 0)][1];
            if (next - point[0] < point[0] - end) facet++;
        }
        const std::int64_t* nodes = nodes_of(facet);
        const double start = placed_[nodes[0]][1];
        where[0] = (point[0] - start) / (placed_[nodes[1]][1] - start);
        settle_on(facet, point, where);
        return facet;
    }

    /// The facet in space that a point is on or nearest to, with its coordinates there filled in.
    ///
    /// Nearness is judged on facets taken as spanned by two edges; bent ones end elsewhere, so that the
    /// nearest few are tried where the first one does not hold the point.
    int nearest_facet(const Vec<t>& point, Vec<t>& where) const {
        const int count = static_cast<int>(spanned_.size()), tries = std::min(FACETS_TRIED, count);
        std::array<double, FACETS_TRIED> misses;
        std::array<int, FACETS_TRIED> tried{};
        misses.fill(INFINITY);
        for (int facet = 0; facet < count; facet++) {
            const double miss = outside_by(spanned_[facet].coordinates(point));
            int last = tries - 1;
            if (!(miss < misses[last])) continue;
            for (; last > 0 && miss < misses[last - 1]; last--) {
                misses[last] = misses[last - 1];
                tried[last] = tried[last - 1];
            }
            misses[last] = miss;
            tried[last] = facet;
        }
        double least = INFINITY;
        int best = tried[0];
        for (int k = 0; k < tries && !(misses[k] > least + FARTHER); k++) {
            const int facet = tried[k];
            Vec<t> guess = spanned_[facet].coordinates(point);
            settle_on(facet, point, guess);
            const double miss = outside_by(guess);
            if (miss < least || k == 0) {
                least = miss;
                best = facet;
                where = guess;
            }
            if (k == 0 && miss <= shapes_.margin) break;
        }
        return best;
    }

    const FacetShapes& shapes_;
    int k_;  // nodes of a facet
    bool is_triangle_;
    std::array<std::array<double, MOST_NODES>, MOST_NODES> factors_;  // of a monomial in all shape functions
    std::vector<Vec<d>>& placed_ = room<Vec<d>>();     // where the nodes are in the frame, m
    std::vector<Spanned>& spanned_ = room<Spanned>();  // the facets
};

/// Foot points on a face at one instant.
struct FootPoints {
    Indices<2> nodes;   // of the facet of each point, (m, k)
    Array<2> weights;   // shape functions N of these there, (m, k)
    Array<2> slope;     // rise of the face along the tangents of the frame, (m, d - 1)
    Array<3> stretch;   // current over undeformed tangential lengths, (m, d - 1, d - 1)
    Array<2> place;     // (g, s), (m, d), m
    Array<2> position;  // positions of the nodes of the face, (n, d), m
};

/// How the closest point of one point moves in a step.
template <int d> struct ProjectionIncrement {
    static constexpr int t = d - 1;

    Vec<d> increment;   // e = (e_n, e_t), m
    Vec<t> ds;          // in the undeformed face, m
    Vec<t> kappa;       // slope of the increment where the closest point moves, else of the surface
    Mat<t, t> stretch;  // a, likewise
    double share;       // of the increment's own slope and stretch

    /// Takes the number of the point, foot points at t_n and t_{n+1}, rows normal and tangents of the
    /// face, and the length of its smallest facet, m.
    ProjectionIncrement(std::ptrdiff_t p, const FootPoints& old, const FootPoints& now, const Mat<d, d>& frame,
                        double facet) {
        Vec<d> moved{};
        for (std::ptrdiff_t k = 0; k < now.nodes.length(1); k++) {
            const double *old_first = &old.position(old.nodes(p, k), 0), *new_first = &now.position(old.nodes(p, k), 0);
            const double *old_last = &old.position(now.nodes(p, k), 0), *new_last = &now.position(now.nodes(p, k), 0);
            for (int i = 0; i < d; i++) {
                const double before = 0.5 * (old_first[i] + new_first[i]), after = 0.5 * (old_last[i] + new_last[i]);
                moved[i] += now.weights(p, k) * after - old.weights(p, k) * before;
            }
        }
        increment = mul(frame, moved);
        double squares = 0, along = 0;
        for (int i = 0; i < t; i++) {
            ds[i] = now.place(p, 1 + i) - old.place(p, 1 + i);
            kappa[i] = 0.5 * (old.slope(p, i) + now.slope(p, i));
            squares += ds[i] * ds[i];
            along += increment[1 + i] * increment[1 + i];
            for (int j = 0; j < t; j++) stretch[i][j] = 0.5 * (old.stretch(p, i, j) + now.stretch(p, i, j));
        }
        share = std::min(std::max(std::sqrt(squares) / (STANDING_STILL * facet) - 1, 0.0), 1.0);
        if (share > 0) take_own(squares, along);
    }

  private:
    /// Makes the least changes after which kappa . e_t = e_n and a ds = e_t, or a share of them.
    void take_own(double squares, double along) {
        double lift = increment[0];
        for (int i = 0; i < t; i++) lift -= kappa[i] * increment[1 + i];
        for (int i = 0; i < t; i++) {
            kappa[i] += share * lift / along * increment[1 + i];
            double missing = increment[1 + i];
            for (int j = 0; j < t; j++) missing -= stretch[i][j] * ds[j];
            for (int j = 0; j < t; j++) stretch[i][j] += share * missing * ds[j] / squares;
        }
    }
};

/// The vector in space of a normal and tangential force, N, whose work is exact: f_n (n - kappa t) + a^-T f_t.
template <int d>
Vec<d> force_in_space(const ProjectionIncrement<d>& step, const Mat<d, d>& frame, const Vec<d>& force) {
    const auto inverse = inverted(step.stretch);
    Vec<d> local{force[0]};
    for (int i = 0; i < d - 1; i++) {
        local[1 + i] = -force[0] * step.kappa[i];
        for (int j = 0; j < d - 1; j++) local[1 + i] += inverse[j][i] * force[1 + j];
    }
    return transposed_mul(frame, local);
}

/// Adds the work of this vector less that of the force on (g, s) to a total, J.
template <int d> void add_work_defect(const ProjectionIncrement<d>& step, const Vec<d>& force, double& total) {
    const auto inverse = inverted(step.stretch);
    total += force[0] * step.increment[0];
    for (int i = 0; i < d - 1; i++) {
        double drag = -step.ds[i];
        for (int j = 0; j < d - 1; j++) drag += inverse[i][j] * step.increment[1 + j];
        total += force[1 + i] * drag - force[0] * step.kappa[i] * step.increment[1 + i];
    }
}

}  // namespace rockslip
