// Motions of a meshed body in the frame that turns with it.
//
// Nodes are d numbers each, one after another. A body moves by R x; forces add S p to x of all nodes, with
// p their sum.
#pragma once

#include <algorithm>
#include <vector>

#include "polar.hpp"
#include "small_arrays.hpp"

namespace rockslip {

/// How a body is turned: R at the end of a step, R_m in its middle, and the shift S = (R^T R_m - I)/(w m),
/// m/N, which moves all nodes by what their forces make together.
template <int d> struct Turns {
    Mat<d, d> rotation, middle, shift;

    explicit Turns(const double* entries)
        : rotation(matrix_at<d>(entries)), middle(matrix_at<d>(entries + d * d)),
          shift(matrix_at<d>(entries + 2 * d * d)) {}

    /// From the rotation at the start of a step to that at its end, by the inertia w m, N/m.
    Turns(const Mat<d, d>& start, const Mat<d, d>& end, double inertia)
        : rotation(end), middle(polar_factor(mean(start, end))) {
        for (int i = 0; i < d; i++)
            for (int j = 0; j < d; j++) {
                shift[i][j] = i == j ? -1.0 : 0.0;
                for (int k = 0; k < d; k++) shift[i][j] += rotation[k][i] * middle[k][j];
                shift[i][j] /= inertia;
            }
    }
};

/// Fills in multiples of R_m^T x of the vectors x of nodes; returns their sum.
template <int d>
Vec<d> into_frame(const double* vectors, std::ptrdiff_t nodes, const Mat<d, d>& middle, double factor, double* turned) {
    Vec<d> total{};
    for (std::ptrdiff_t n = 0; n < d * nodes; n += d) {
        const Vec<d> along = factor * transposed_mul(middle, vector_at<d>(vectors + n));
        std::copy_n(along.begin(), d, turned + n);
        total += along;
    }
    return total;
}

/// A force of a point in its frame of normal and tangents, times a weight, as a vector in a turned frame.
template <int d>
Vec<d> point_vector(const double* force, double weight, const double* frame, const Mat<d, d>& rotation) {
    Vec<d> space{};
    for (int k = 0; k < d; k++)
        for (int i = 0; i < d; i++) space[i] += weight * force[k] * frame[d * k + i];
    return transposed_mul(rotation, space);
}

/// Fills in R (x + y) of two motions of nodes.
template <int d>
void out_of_frame(const double* nodes, const double* others, std::ptrdiff_t count, const Mat<d, d>& rotation,
                  double* moved) {
    for (std::ptrdiff_t n = 0; n < d * count; n += d) {
        const Vec<d> found = mul(rotation, vector_at<d>(nodes + n) + vector_at<d>(others + n));
        std::copy_n(found.begin(), d, moved + n);
    }
}

/// Adds S p of vectors of forces (m, d) to all nodes alike.
template <int d>
void add_shift(const double* vectors, std::ptrdiff_t count, const Mat<d, d>& shift, double* nodes,
               std::ptrdiff_t all) {
    Vec<d> total{};
    for (std::ptrdiff_t p = 0; p < d * count; p += d) total += vector_at<d>(vectors + p);
    const Vec<d> further = mul(shift, total);
    for (std::ptrdiff_t n = 0; n < d * all; n++) nodes[n] += further[static_cast<std::size_t>(n % d)];
}

/// Adds motions of points (m, d) in the frame of their body to their places over a carrier: they count with a
/// sign, -1 where the body carries the points. Frames are of all points (1, d, d) or of each.
template <int d>
void add_places(double* places, std::ptrdiff_t count, double sign, const double* motions, const Array<3>& frames,
                const Mat<d, d>& rotation) {
    Mat<d, d> turned{};
    for (std::ptrdiff_t p = 0; p < count; p++) {
        if (p < frames.length()) {
            turned = {};
            add_product(turned, matrix_at<d>(frames[p].data()), rotation, 1.0);
        }
        const double* moved = motions + d * p;
        double* place = places + d * p;
        for (int i = 0; i < d; i++)
            for (int j = 0; j < d; j++) place[i] += sign * turned[i][j] * moved[j];
    }
}

/// Adds `weight` times the compliance of a turned body among points to W, (m, d, m, d), m/N.
///
/// Frames have rows normal and tangents at each point, (m, d, d); C is the compliance in the frame that
/// turns, (m, d, m, d), m/N; `share` says how much of each point's force the body gets, (m,).
template <int d>
void add_compliance(double* W, double weight, const Array<3>& frames, const Turns<d>& turns, const double* C,
                    const double* share) {
    static thread_local std::vector<Mat<d, d>> moved, pushed;
    const std::ptrdiff_t m = frames.length();
    moved.assign(m, {});
    pushed.assign(m, {});
    for (std::ptrdiff_t p = 0; p < m; p++) {
        const Mat<d, d> frame = matrix_at<d>(frames[p].data());
        add_product(moved[p], frame, turns.rotation, 1.0);
        add_product(pushed[p], frame, turns.middle, 1.0);
        for (Vec<d>& row : moved[p]) row = weight * row;
    }
    for (std::ptrdiff_t p = 0; p < m; p++)
        for (std::ptrdiff_t q = 0; q < m; q++) {
            const double both = share[p] * share[q];
            Mat<d, d> half;
            for (int k = 0; k < d; k++) {
                const double* column = C + ((p * d + k) * m + q) * d;
                Vec<d> own;
                for (int n = 0; n < d; n++) own[n] = column[n] + both * turns.shift[k][n];
                half[k] = mul(pushed[q], own);
            }
            for (int i = 0; i < d; i++) {
                double* row = W + ((p * d + i) * m + q) * d;
                for (int j = 0; j < d; j++) {
                    double sum = row[j];
                    for (int k = 0; k < d; k++) sum += moved[p][i][k] * half[k][j];
                    row[j] = sum;
                }
            }
        }
}

/// Largest change of the entries of both rotations between two `turns` of a body.
inline double largest_turn(const Array<3>& now, const Array<3>& before) {
    const std::ptrdiff_t rotations = 2 * now.length(1) * now.length(2);
    double largest = 0.0;
    for (std::ptrdiff_t i = 0; i < rotations; i++)
        largest = std::max(largest, std::fabs(now.data()[i] - before.data()[i]));
    return largest;
}

/// The points of one interface among those of all, which are numbered on from interface to interface.
struct PointRange {
    std::int64_t first, count;

    bool holds(std::int64_t number) const { return first <= number && number < first + count; }
};

/// Marks the ports, counted from `port` on, that near points of an interface act on: `nodes`, (count, k).
inline void mark_ports(const Indices<1>& near, const PointRange& points, std::int64_t port, const Indices<2>& nodes,
                       const MaskOut<1>& used) {
    for (const std::int64_t number : near)
        if (points.holds(number))
            for (const std::int64_t node : nodes[number - points.first]) used[port + node] = true;
}

/// Adds how much of their forces, `weights` (count, k), near points of an interface put on ports to `load`,
/// (near, ports); the ports there rise. Otherwise as `mark_ports`.
inline void add_loads(const Indices<1>& near, const PointRange& points, std::int64_t port, const Indices<2>& nodes,
                      const Array<2>& weights, double sign, const Indices<1>& ports, const Output<2>& load) {
    for (std::ptrdiff_t i = 0; i < near.length(); i++) {
        if (!points.holds(near[i])) continue;
        const std::int64_t p = near[i] - points.first;
        for (std::ptrdiff_t a = 0; a < nodes.length(1); a++) {
            const auto* place = std::lower_bound(ports.begin(), ports.end(), port + nodes(p, a));
            load(i, place - ports.begin()) += sign * weights(p, a);
        }
    }
}

}  // namespace rockslip
