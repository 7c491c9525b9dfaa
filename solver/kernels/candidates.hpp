// Points that may come into contact in a correction, and what becomes of their forces.
#pragma once

#include <tuple>
#include <vector>

#include "dense_problem.hpp"

namespace rockslip {

/// What can become of a correction's contact problem; `solver.stepping.step_contact` has the same numbers.
enum Settled : std::int64_t {
    NOTHING_NEAR,  // no point is near
    OTHERS_NEAR,   // than those whose compliance there is
    LEFT_OPEN,     // free values are there, the problem is left to the caller
    UNSETTLED,     // by all methods
    SETTLED,
};

/// All contact points after a free step.
struct FreePoints {
    Array<2> y;          // augmented positions, (points, d), m
    Array<1> margin;     // gaps below which points may come into contact, (points,), m
    Mask<1> may_touch;   // (points,)
    Array<2> anchor;     // stick memory, (points, d-1), m
    Array<1> softness;   // of the interface, (points,), m/N: no part of y
    Array<2> held;       // forces that those so far are compared with, (points, d), N
    Array<1> bed;        // softness of the beds below them, (points,), m/N
    Array<1> round_off;  // of the gaps, (points,), m
};

/// The points that an operator belongs to.
struct NearPoints {
    Indices<1> number;
    Array<4> compliance;  // (m, d, m, d), m/N; it holds softness, softening and beds
    Array<1> softening;   // (m,), m/N: acts on what forces differ by from held ones
};

/// Fills in the numbers, rising, of points that may come into contact; returns how many there are. By their
/// forces so far, (points, d), N; `number` has room for all.
inline std::ptrdiff_t candidates(const FreePoints& points, Array<2> force, IndicesOut<1> number) {
    std::ptrdiff_t count = 0;
    for (std::ptrdiff_t p = 0; p < points.y.length(); p++)
        if ((points.y(p, 0) < points.margin[p] && points.may_touch[p]) || force(p, 0) > 0) number[count++] = p;
    return count;
}

/// Whether points that may touch, but were never near, are in their carrier at positions y, (points, d), m.
inline bool sinks_in(Array<2> y, Array<1> round_off, Mask<1> may_touch, Mask<1> seen) {
    for (std::ptrdiff_t p = 0; p < y.length(); p++)
        if (y(p, 0) < -round_off[p] && may_touch[p] && !seen[p]) return true;
    return false;
}

/// Fills in a guess of the forces of near points, (m, d), N, from those of all so far, and free values q with
/// y = q + W f, (m, d), m.
inline void free_values(const FreePoints& points, const NearPoints& near, Array<2> force, Output<2> start,
                        Output<2> q) {
    const std::ptrdiff_t m = q.length(), d = q.length(1);
    bool pressed = false;
    for (std::ptrdiff_t i = 0; i < m; i++)
        for (std::ptrdiff_t k = 0; k < d; k++) {
            start(i, k) = force(near.number[i], k);
            pressed = pressed || start(i, k) != 0;
        }
    const double* row = near.compliance.data();
    for (std::ptrdiff_t i = 0; i < m; i++) {
        const std::ptrdiff_t p = near.number[i];
        for (std::ptrdiff_t k = 0; k < d; k++, row += m * d) {
            double value = points.y(p, k) + points.softness[p] * start(i, k);
            value += near.softening[i] * (start(i, k) - points.held(p, k));
            for (std::ptrdiff_t j = 0; j < m * d; j++) value -= row[j] * start.data()[j];
            if (k > 0) value -= points.anchor(p, k - 1);
            q(i, k) = value;
        }
        // Nothing tells that such a gap is small.
        if (!pressed && std::fabs(q(i, 0)) < points.round_off[p]) q(i, 0) = 0;
        q(i, 0) += points.bed[p] * start(i, 0);
    }
}

/// Replaces the forces of near points among all, (points, d), N; fills in new forces less those before, (m, d), N,
/// and returns the sum of the squares of the new ones, N2.
inline double take_over(Output<2> force, Indices<1> near, Array<2> now, Output<2> change) {
    double squares = 0;
    for (std::ptrdiff_t i = 0; i < near.length(); i++)
        for (std::ptrdiff_t k = 0; k < now.length(1); k++) {
            double& own = force(near[i], k);
            change(i, k) = now(i, k) - own;
            own = now(i, k);
            squares += own * own;
        }
    return squares;
}

/// Lets the forces of near points obey the contact law after a free step, in one pass.
///
/// Returns what became of that, how many points are near, and the sum of the squares of their forces, N2. Fills in
/// the numbers of the points that are near, the free values of those of the operator and how much their forces
/// changed; where others are near nothing else is changed. `alone`: the problem is solved here, not left to the
/// caller. Bounds are those of all points; `counts` counts outcomes of local problems.
inline std::tuple<std::int64_t, std::int64_t, double> settle(const FreePoints& points, const NearPoints& near,
                                                             const PointBounds& bounds, bool alone, Output<2> force,
                                                             IndicesOut<1> number, IndicesOut<1> counts, Output<2> q,
                                                             Output<2> change) {
    const std::ptrdiff_t count = candidates(points, force, number);
    if (count == 0) return {NOTHING_NEAR, count, 0.0};
    if (count != near.number.length() || !std::equal(near.number.begin(), near.number.end(), number.begin()))
        return {OTHERS_NEAR, count, 0.0};
    static thread_local struct {
        std::vector<double> mu, cohesion, now;
    } kept;
    const Output<1> mu = room(kept.mu, count), cohesion = room(kept.cohesion, count);
    const Output<2> now = room(kept.now, count, q.length(1));
    for (std::ptrdiff_t i = 0; i < count; i++) {
        mu[i] = bounds.mu[near.number[i]];
        cohesion[i] = bounds.cohesion[near.number[i]];
    }
    free_values(points, near, force, now, q);
    if (!alone) return {LEFT_OPEN, count, 0.0};
    if (!solve_points(near.compliance, q, mu, cohesion, bounds.slope, now, counts)) return {UNSETTLED, count, 0.0};
    return {SETTLED, count, take_over(force, near.number, now, change)};
}

/// Adds to the diagonal of near points' compliance W, (m, d, m, d), m/N: the softness of the interface at all
/// points, (points,), and further terms at the near ones, (m,).
inline void add_softness(Output<4> W, Indices<1> near, Array<1> softness, Array<1> added) {
    for (std::ptrdiff_t i = 0; i < near.length(); i++)
        for (std::ptrdiff_t k = 0; k < W.length(1); k++) W(i, k, i, k) += softness[near[i]] + added[i];
}

}  // namespace rockslip
