// Contact at velocity level, after each step: `solver.law.velocity` says what for, (M40) to (M42).
//
// Four problems are tried for the impulses, one after another: in 0 all points obey the law; in 1, points that
// slipped stay at their bound; in 2 they keep their friction; in 3 all points do.
#pragma once

#include <tuple>
#include <vector>

#include "dense_problem.hpp"
#include "point_friction.hpp"

namespace rockslip {

/// Relative diagonal added to W: closed points may outnumber the unknowns, W is singular then.
constexpr double IMPULSE_REGULAR = 1e-8;

/// Gains of kinetic energy below this part of the power of the impulses are round-off.
constexpr double ENERGY_ROUND_OFF = 1e-14;

/// The closed points after a step; m points in d dimensions, in their frames.
struct ClosedPoints {
    Array<4> mobility;   // W = G M^-1 G^T, (m, d, m, d), 1/kg
    Array<2> velocity;   // after the step, (m, d), m/s
    Array<2> impulse;    // dt f of the step, (m, d), N s
    PointBounds bounds;  // of the impulses: mu and dt c

    std::ptrdiff_t count() const { return impulse.length(); }
    std::ptrdiff_t dimension() const { return impulse.length(1); }
    std::ptrdiff_t rows() const { return impulse.size(); }
};

/// All numbers of points, or a matrix of theirs, point after point.
template <class T> View<T, 1> flat(const View<T, 2>& vectors) { return {vectors.data(), {vectors.size()}}; }
template <class T> View<T, 2> flat(const View<T, 4>& matrix) {
    const std::ptrdiff_t rows = matrix.length() * matrix.length(1);
    return {matrix.data(), {rows, rows}};
}

/// A problem for the impulses of closed points, to be filled in.
struct ImpulseProblem {
    Output<4> mobility;      // with the friction that follows the normal impulses, (m, d, m, d), 1/kg
    Output<2> free;          // velocities without impulses but those given, (m, d), m/s
    Output<1> mu, cohesion;  // bounds of the impulses; 0 where friction is no unknown
    Output<2> start;         // guess of the impulses that are unknown, (m, d), N s
};

/// Friction of a point that is no unknown: parts of the tangential impulse of the step.
struct KnownFriction {
    bool known;
    double given;     // acts in any case
    double followed;  // for each unit of the normal impulse, besides; 1/(N s)
};

/// What is known of the friction of a point in the problem of a number.
inline KnownFriction known_friction(int number, const ClosedPoints& points, std::ptrdiff_t point) {
    const Array<1> impulse = points.impulse[point];
    double size = 0;
    for (std::ptrdiff_t k = 1; k < impulse.length(); k++) size = std::hypot(size, impulse[k]);
    const PointBounds& bounds = points.bounds;
    if (number == 0 || (number < 3 && !bounds.at_bound(point, impulse[0], size))) return {false, 0, 0};
    if (number > 1 || !(size > 0)) return {true, 1, 0};
    return {true, bounds.cohesion[point] / size, bounds.mu[point] / size};
}

/// Fills in the problem of a number.
inline void impulse_problem(int number, const ClosedPoints& points, const ImpulseProblem& problem) {
    const std::ptrdiff_t d = points.dimension(), rows = points.rows();
    const Output<2> W = flat(problem.mobility);
    const Output<1> free = flat(problem.free), start = flat(problem.start);
    const Array<1> impulse = flat(points.impulse), velocity = flat(points.velocity);
    std::copy(points.mobility.begin(), points.mobility.end(), W.begin());
    for (std::ptrdiff_t k = 0; k < rows; k++) W(k, k) *= 1 + IMPULSE_REGULAR;
    product(W, impulse, free);
    for (std::ptrdiff_t k = 0; k < rows; k++) {
        free[k] = velocity[k] - free[k];
        start[k] = impulse[k];
    }
    for (std::ptrdiff_t p = 0; p < points.count(); p++) {
        problem.mu[p] = points.bounds.mu[p];
        problem.cohesion[p] = points.bounds.cohesion[p];
        const auto [known, given, followed] = known_friction(number, points, p);
        if (!known) continue;
        problem.mu[p] = problem.cohesion[p] = 0;
        for (std::ptrdiff_t n = d * p, k = n + 1; k < n + d; k++) {
            start[k] = 0;
            const double acts = given * impulse[k], follows = followed * impulse[k];
            for (std::ptrdiff_t i = 0; i < rows; i++) {
                W(i, n) += W(i, k) * follows;
                free[i] += W(i, k) * acts;
            }
        }
    }
}

/// Turns the solution of the problem of a number, (m, d), N s, into the change of the impulses; returns whether
/// energy allows it, and what it takes in the normal and in the tangential directions, J.
///
/// The correction may return what friction took in the step, `taken`, J.
inline std::tuple<bool, double, double> accept_impulses(int number, const ClosedPoints& points, double taken,
                                                        Output<2> solution) {
    const std::ptrdiff_t d = points.dimension(), rows = points.rows();
    const Array<1> impulse = flat(points.impulse), velocity = flat(points.velocity);
    const Output<1> q = flat(solution);
    for (std::ptrdiff_t p = 0; p < points.count(); p++) {
        const auto [known, given, followed] = known_friction(number, points, p);
        for (std::ptrdiff_t n = d * p, k = n + 1; known && k < n + d; k++)
            q[k] += given * impulse[k] + followed * impulse[k] * q[n];
    }
    for (std::ptrdiff_t k = 0; k < rows; k++) q[k] -= impulse[k];
    static thread_local std::vector<double> kept;
    const Output<1> gained = room(kept, rows);
    product(flat(points.mobility), q, gained);
    double normal = 0, lost = 0, power = 0;
    for (std::ptrdiff_t k = 0; k < rows; k++) {
        const double work = q[k] * (velocity[k] + 0.5 * gained[k]);
        lost -= work;
        if (k % d == 0) normal -= work;
        power += impulse[k] * velocity[k];
    }
    const double returned = std::max(taken, 0.0);
    if (lost + returned < -ENERGY_ROUND_OFF * std::fabs(power)) return {false, 0, 0};
    const double friction = friction_share(lost - normal, lost, returned);
    return {true, lost - friction, friction};
}

/// Fills in the change of the impulses of closed points, (m, d), N s; returns as `accept_impulses`.
///
/// Counts outcomes of local problems, the last of which is that no correction was found. `lands`: a rigid body
/// landed in the step.
inline std::tuple<bool, double, double> correct_impulses(const ClosedPoints& points, double taken, bool lands,
                                                         IndicesOut<1> counts, Output<2> q) {
    const std::ptrdiff_t m = points.count(), d = points.dimension();
    static thread_local struct {
        std::vector<double> mobility, free, mu, cohesion;
        std::vector<std::int64_t> states;
    } kept;
    const ImpulseProblem problem{room(kept.mobility, m, d, m, d), room(kept.free, m, d), room(kept.mu, m),
                                 room(kept.cohesion, m), q};
    const PointBounds left{problem.mu, problem.cohesion, points.bounds.slope};
    const IndicesOut<1> states = room(kept.states, m);
    for (int number = lands ? 0 : 1; number < 4; number++) {
        impulse_problem(number, points, problem);
        const DenseProblem dense{static_cast<int>(d), flat(problem.mobility), flat(problem.free), left};
        if (!solve(dense.d, dense.W, dense.q, dense.bounds, flat(q), states, counts)) continue;
        const auto found = accept_impulses(number, points, taken, q);
        if (std::get<0>(found)) return found;
    }
    counts[counts.length() - 1]++;
    return {false, 0, 0};
}

/// Speed at which points slip back at the end of a step, m/s, a mean over their friction.
///
/// Friction opposes the slip of the step as a whole. Where the slip turned round within the step, friction drives
/// what it should by now oppose. 0 where it does not. By forces, N, and velocities, m/s, of closed points, (m, d).
inline double slip_reversal(Array<2> force, Array<2> velocity) {
    double power = 0, friction = 0;
    for (std::ptrdiff_t p = 0; p < force.length(); p++) {
        for (std::ptrdiff_t k = 1; k < force.length(1); k++) power += force(p, k) * velocity(p, k);
        friction += tangential_size(force[p]);
    }
    return power > 0 ? power / friction : 0;
}

}  // namespace rockslip
