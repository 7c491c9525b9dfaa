// The local contact problem with a dense compliance: Signorini and Coulomb at m points, d numbers each.
//
// Unknown are the forces f = (normal, tangential) of the points, with
//
//     y = q + W f,   0 <= f_n  complementary to  y_n >= 0,
//     |f_t| <= mu f_n + min(c, s f_n),   y_t opposite to f_t where |f_t| is at its bound, 0 elsewhere,
//
// and f_t = 0 where f_n = 0: cohesion needs contact. They are the root of f - P(f - r y), with P the
// projection on the admissible forces: normal part first, then the disc, which is an interval for
// d = 2 and absent for d = 1. The method is that of Alart and Curnier (1991). For d <= 2 it is the
// active-set method: the state of each point, by f - r y, decides its forces, and the states are right
// when they repeat themselves. Where Newton's method with full steps does not settle a problem, the
// proximal point algorithm does, by full steps, too; how often is counted.
#pragma once

#include <vector>

#include "linear.hpp"
#include "point_bounds.hpp"

namespace rockslip {

/// A local problem.
struct DenseProblem {
    int d;               // rows of a point: 3 in space, 2 in the plane, 1 without friction
    Array<2> W;          // compliance, (d m, d m), m/N; rows of a point side by side, normal first
    Array<1> q;          // free values, (d m,), m
    PointBounds bounds;  // friction
};

/// States of a point. For d = 2 those of slip carry the sign of the friction force.
struct PointState {
    static constexpr std::int64_t OPEN = 0, STICK = 1, SLIP = 2, SLIP_TOUCHING = 3;
};

/// The outcomes of problems, as counted.
struct Outcome {
    static constexpr std::int64_t NEWTON = 0, PROXIMAL = 1;
};

/// Where the methods end, and what they try.
struct DenseLimits {
    static constexpr double TOLERANCE = 1e-12;         // of a force, relative to the largest of its point
    static constexpr double ROUND_OFF = 64 * 0x1p-52;  // the same, relative to the largest f or r y of all points
    static constexpr double EXACT = 0.02;              // part of these errors that no further step makes smaller
    static constexpr double ENOUGH = 10;               // times these errors, where proximal terms make them no smaller
    static constexpr std::int64_t ROUNDS = 20;         // Newton's linear solves, and two more for each point
    static constexpr std::int64_t EASED_ROUNDS = 12;   // the same for a problem with a proximal term
    static constexpr int PROXIMAL_ROUNDS = 100;        // problems with a proximal term that are tried
    static constexpr double SOFTNESS = 1;              // the first term, relative to the diagonal of W
    static constexpr double HARDEST = 1e-12, SOFTEST = 1e4;  // the least that is not 0, and the largest one
    static constexpr double HARDENING = 0.1, SOFTENING = 3;  // factors of the term after a problem solved and one not
    static constexpr double FOLLOWED = 0.1;            // part of the slope of friction in a normal length r
    static constexpr double SHORTER = 1e-3;            // of it, where Newton's method does not settle with that
    static constexpr int ONE_POINT_HALVINGS = 200;     // of the interval of the shift of a slipping point
};

// Numbers and dense algebra -----------------------------------------------------------------------

/// Room for an array, kept from call to call.
template <class T, class... Length>
View<T, static_cast<int>(sizeof...(Length))> room(std::vector<T>& kept, Length... length) {
    const std::size_t size = (static_cast<std::size_t>(length) * ...);
    if (kept.size() < size) kept.resize(size);
    return {kept.data(), {static_cast<std::ptrdiff_t>(length)...}};
}

/// The product of a square matrix and a vector.
inline void product(Array<2> matrix, Array<1> vector, Output<1> found) {
    const std::ptrdiff_t size = vector.length();
    std::ptrdiff_t i = 0;
    for (; i + 4 <= size; i += 4) {  // four rows at once: the terms of one sum wait for one another
        const double *m0 = matrix[i].data(), *m1 = m0 + size, *m2 = m1 + size, *m3 = m2 + size;
        double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
        for (std::ptrdiff_t k = 0; k < size; k++) {
            const double x = vector[k];
            s0 += m0[k] * x;
            s1 += m1[k] * x;
            s2 += m2[k] * x;
            s3 += m3[k] * x;
        }
        found[i] = s0;
        found[i + 1] = s1;
        found[i + 2] = s2;
        found[i + 3] = s3;
    }
    for (; i < size; i++) {
        double sum = 0;
        for (std::ptrdiff_t k = 0; k < size; k++) sum += matrix(i, k) * vector[k];
        found[i] = sum;
    }
}

/// Gaussian elimination of a panel: of `width` unknowns from k on, by the largest pivots, in its own columns; rows
/// are swapped as a whole, factors kept in place of the zeros. False where a pivot is missing.
inline bool eliminate_panel(Output<2> matrix, Output<1> right, std::ptrdiff_t first, std::ptrdiff_t width) {
    const std::ptrdiff_t size = right.length(), end = first + width;
    for (std::ptrdiff_t k = first; k < end; k++) {
        std::ptrdiff_t pivot = k;
        for (std::ptrdiff_t i = k + 1; i < size; i++)
            if (std::fabs(matrix(i, k)) > std::fabs(matrix(pivot, k))) pivot = i;
        const double divisor = matrix(pivot, k);
        if (!(0.0 < std::fabs(divisor) && std::fabs(divisor) < INFINITY)) return false;
        if (pivot != k) {
            std::swap_ranges(matrix[k].begin(), matrix[k].end(), matrix[pivot].begin());
            std::swap(right[k], right[pivot]);
        }
        for (std::ptrdiff_t i = k + 1; i < size; i++) {
            const double factor = matrix(i, k) /= divisor;
            for (std::ptrdiff_t j = k + 1; j < end; j++) matrix(i, j) -= factor * matrix(k, j);
        }
    }
    return true;
}

/// Solves a linear system, `right` becoming the solution; false where it is singular. The matrix is used up.
///
/// Four unknowns are eliminated at once, so that a row is read and written once for them; numbers are those of
/// one after another.
inline bool solve_dense(Output<2> matrix, Output<1> right) {
    constexpr std::ptrdiff_t PANEL = 4;
    const std::ptrdiff_t size = right.length();
    for (std::ptrdiff_t first = 0; first < size; first += PANEL) {
        const std::ptrdiff_t width = std::min(PANEL, size - first), end = first + width;
        if (!eliminate_panel(matrix, right, first, width)) return false;
        for (std::ptrdiff_t i = first + 1; i < end; i++)
            for (std::ptrdiff_t k = first; k < i; k++) {
                const double factor = matrix(i, k);
                const double* from = matrix[k].data();
                double* row = matrix[i].data();
                for (std::ptrdiff_t j = end; j < size; j++) row[j] -= factor * from[j];
                right[i] -= factor * right[k];
            }
        if (end == size) break;  // only the last panel is narrower: others have rows below
        const double *p0 = matrix[first].data(), *p1 = p0 + size, *p2 = p1 + size, *p3 = p2 + size;
        for (std::ptrdiff_t i = end; i < size; i++) {
            double* row = matrix[i].data();
            const double f0 = row[first], f1 = row[first + 1], f2 = row[first + 2], f3 = row[first + 3];
            if (f0 == 0 && f1 == 0 && f2 == 0 && f3 == 0) continue;  // points of bodies that do not touch
            for (std::ptrdiff_t j = end; j < size; j++)
                row[j] = row[j] - f0 * p0[j] - f1 * p1[j] - f2 * p2[j] - f3 * p3[j];
            const double* known = &right[first];
            right[i] = right[i] - f0 * known[0] - f1 * known[1] - f2 * known[2] - f3 * known[3];
        }
    }
    for (std::ptrdiff_t k = size - 1; k >= 0; k--) {
        for (std::ptrdiff_t j = k + 1; j < size; j++) right[k] -= matrix(k, j) * right[j];
        right[k] /= matrix(k, k);
        if (!(std::fabs(right[k]) < INFINITY)) return false;
    }
    return true;
}

// Newton's method ---------------------------------------------------------------------------------

/// The lengths r, normal and tangential, (m, 2): one over row sums of |W| within a direction; N/m.
///
/// Points of a stiff body share its rigid modes: W is nearly of low rank, and one over its diagonal too large by about
/// the number of points.
inline void lengths(std::int64_t d, Array<2> W, Output<2> r) {
    for (std::ptrdiff_t i = 0; i < r.length(); i++) {
        double compliance[2] = {0.0, d > 1 ? 0.0 : 1.0};
        for (std::ptrdiff_t k = 0; k < d; k++) {  // one length for both tangential directions: a disc has no favourite
            const Array<1> row = W[d * i + k];
            double sum = 0.0;
            for (std::ptrdiff_t j = k; j < row.length(); j += d) sum += std::fabs(row[j]);
            compliance[k > 0] = std::max(compliance[k > 0], sum);
        }
        r(i, 0) = 1.0 / compliance[0];
        r(i, 1) = 1.0 / compliance[1];
    }
}

/// The trial forces f - r y, which decide the state of each point, (d m,), N.
inline void trial_of(const DenseProblem& problem, Array<2> r, Array<1> f, Output<1> trial) {
    const std::ptrdiff_t d = problem.d;
    product(problem.W, f, trial);
    for (std::ptrdiff_t i = 0; i < r.length(); i++)
        for (std::ptrdiff_t k = d * i; k < d * i + d; k++)
            trial[k] = f[k] - r(i, k > d * i) * (problem.q[k] + trial[k]);
}

/// Writes the admissible forces nearest to trial ones, and the states these stand for.
inline void project(const DenseProblem& problem, Array<1> trial, Output<1> nearest, IndicesOut<1> states) {
    const std::ptrdiff_t d = problem.d;
    nearest.fill(0.0);
    for (std::ptrdiff_t i = 0; i < states.length(); i++) {
        const std::ptrdiff_t n = d * i;
        const double normal = trial[n];
        states[i] = PointState::OPEN;
        if (!(normal > 0.0)) continue;
        nearest[n] = normal;
        const auto [slope, intercept] = problem.bounds[i].line(normal);
        const double limit = slope * normal + intercept;
        double size = 0.0;
        for (std::ptrdiff_t k = n + 1; k < n + d; k++) size = std::hypot(size, trial[k]);
        if (size <= limit && limit > 0.0) {
            states[i] = PointState::STICK;
            for (std::ptrdiff_t k = n + 1; k < n + d; k++) nearest[k] = trial[k];
            continue;
        }
        const bool slips_whole = intercept > 0.0 || problem.bounds.cohesion[i] == 0.0;
        states[i] = slips_whole ? PointState::SLIP : PointState::SLIP_TOUCHING;
        if (d == 2 && trial[n + 1] < 0.0) states[i] = -states[i];
        for (std::ptrdiff_t k = n + 1; k < n + d; k++) nearest[k] = limit > 0.0 ? limit / size * trial[k] : 0.0;
    }
}

/// Writes the rows that have to be solved for, given the states, and returns their number; the other forces follow
/// from these.
inline std::int64_t unknowns(const DenseProblem& problem, Indices<1> states, IndicesOut<1> rows) {
    const std::int64_t d = problem.d;
    std::int64_t count = 0;
    for (std::ptrdiff_t i = 0; i < states.length(); i++) {
        if (states[i] == PointState::OPEN) continue;
        const bool smooth = problem.bounds.mu[i] == 0.0 && problem.bounds.cohesion[i] == 0.0;
        const bool has_direction = states[i] == PointState::STICK || (d == 3 && !smooth);
        for (std::int64_t k = 0; k < (has_direction ? d : 1); k++) rows[count++] = d * i + k;
    }
    return count;
}

/// Turns rows a and a + 1, r W and -r q of a point i that slips in space, into those of slip.
///
/// P = l e with e = tau/|tau|, of derivative e dl + (l/|tau|)(I - e e^T) dtau; I - e e^T = b b^T.
inline void slip_rows(const PointBounds& bounds, Array<1> trial, std::ptrdiff_t i, std::ptrdiff_t a, Output<2> matrix,
                      Output<1> right) {
    const auto [slope, intercept] = bounds[i].line(trial[3 * i]);
    const double size = std::hypot(trial[3 * i + 1], trial[3 * i + 2]);
    const double share = (slope * trial[3 * i] + intercept) / size;
    const Vec<2> e{trial[3 * i + 1] / size, trial[3 * i + 2] / size}, b{-e[1], e[0]};
    const Output<1> first = matrix[a], second = matrix[a + 1];
    for (std::ptrdiff_t j = 0; j < right.length(); j++) {
        const double across = share * (b[0] * first[j] + b[1] * second[j]);
        first[j] = b[0] * across;
        second[j] = b[1] * across;
    }
    const double value = share * (b[0] * right[a] + b[1] * right[a + 1]);
    for (std::size_t k = 0; k < 2; k++) {
        const Output<1> row = k ? second : first;
        const std::ptrdiff_t own = a + static_cast<std::ptrdiff_t>(k);
        row[own] += 1.0;
        row[a] -= share * b[k] * b[0];
        row[a + 1] -= share * b[k] * b[1];
        row[a - 1] -= slope * e[k];
        right[own] = e[k] * intercept + b[k] * value;
    }
}

/// Writes matrix A and right-hand side b of f - P(f - r y) = 0, linearised at `trial`: A x = b.
///
/// The unknowns x are the forces of some rows, those of `unknowns`.
inline void equations(const DenseProblem& problem, Array<2> r, Array<1> trial, Indices<1> states, Indices<1> rows,
                      Output<2> matrix, Output<1> right) {
    const std::ptrdiff_t d = problem.d, size = rows.length();
    for (std::ptrdiff_t a = 0; a < size; a++) {
        const std::ptrdiff_t row = rows[a];
        const Array<1> compliance = problem.W[row];
        const Output<1> equation = matrix[a];
        // Rows r y = 0: unscaled ones beside rows of forces would lose digits.
        const double weight = r(row / d, row % d > 0);
        right[a] = -weight * problem.q[row];
        for (std::ptrdiff_t b = 0; b < size; b++) equation[b] = weight * compliance[rows[b]];
        if (d != 2) continue;
        for (std::ptrdiff_t b = 0; b < size; b++) {
            const std::ptrdiff_t i = rows[b] / 2;
            if (rows[b] % 2 != 0 || states[i] == PointState::STICK) continue;
            const auto [slope, intercept] = problem.bounds[i].line(trial[2 * i]);
            const double coupling = weight * compliance[2 * i + 1] * (states[i] > 0 ? 1.0 : -1.0);
            equation[b] += slope * coupling;
            right[a] -= intercept * coupling;
        }
    }
    if (d != 3) return;
    for (std::ptrdiff_t a = 0; a < size; a++)
        if (rows[a] % 3 == 1 && states[rows[a] / 3] != PointState::STICK)
            slip_rows(problem.bounds, trial, rows[a] / 3, a, matrix, right);
}

/// Writes all forces by the unknowns x of the equations; the sliding ones follow in the plane.
inline void write_forces(const DenseProblem& problem, Array<1> trial, Indices<1> states, Indices<1> rows, Array<1> x,
                         Output<1> f) {
    f.fill(0.0);
    for (std::ptrdiff_t a = 0; a < rows.length(); a++) f[rows[a]] = x[a];
    if (problem.d != 2) return;
    for (std::ptrdiff_t i = 0; i < states.length(); i++) {
        if (std::abs(states[i]) < PointState::SLIP) continue;
        const auto [slope, intercept] = problem.bounds[i].line(trial[2 * i]);
        f[2 * i + 1] = (slope * f[2 * i] + intercept) * (states[i] > 0 ? 1.0 : -1.0);
    }
}

/// Writes the root f of f - P(f - r y), linearised at `trial`; false where there is none.
inline bool linearised(const DenseProblem& problem, Array<2> r, Array<1> trial, Indices<1> states, Output<1> f) {
    static thread_local struct {
        std::vector<double> matrix, right;
        std::vector<std::int64_t> rows;
    } kept;
    const IndicesOut<1> all = room(kept.rows, f.length());
    const std::int64_t count = unknowns(problem, states, all);
    const Indices<1> rows{all.data(), {count}};
    const Output<2> matrix = room(kept.matrix, count, count);
    const Output<1> right = room(kept.right, count);
    equations(problem, r, trial, states, rows, matrix, right);
    if (!solve_dense(matrix, right)) return false;
    write_forces(problem, trial, states, rows, right, f);
    return true;
}

/// Difference between f and P(f - r y), 1 being what is tolerated; infinite beyond numbers.
inline double error_of(std::int64_t d, Array<1> f, Array<1> trial, Array<1> nearest) {
    double noise = 0.0, worst = 0.0;
    for (std::ptrdiff_t k = 0; k < f.length(); k++) {
        if (!(std::fabs(f[k]) + std::fabs(trial[k]) < INFINITY)) return INFINITY;
        noise = std::max({noise, std::fabs(f[k]), std::fabs(f[k] - trial[k])});
    }
    for (std::ptrdiff_t n = 0; n < f.length(); n += d) {
        double largest = 0.0, difference = 0.0;
        for (std::ptrdiff_t k = n; k < n + d; k++) {
            largest = std::max(largest, std::fabs(f[k]));
            difference = std::max(difference, std::fabs(f[k] - nearest[k]));
        }
        if (difference > 0.0)
            worst = std::max(worst, difference / (DenseLimits::TOLERANCE * largest + DenseLimits::ROUND_OFF * noise));
    }
    return worst;
}

/// Newton's method from f with full steps; whether it settled. If so f is the solution, else it stays as it is.
///
/// `rounds` is the most linear solves; one is made in any case if it `moves`, else only where f is not the solution. The
/// states are left as those of the last forces.
inline bool newton(const DenseProblem& problem, Array<2> r, Output<1> f, IndicesOut<1> states, std::int64_t rounds,
                   bool moves) {
    static thread_local struct {
        std::vector<double> force, trial, nearest;
        std::vector<std::int64_t> before, seen;
    } kept;
    const Output<1> force = room(kept.force, f.length()), trial = room(kept.trial, f.length());
    const Output<1> nearest = room(kept.nearest, f.length());
    const IndicesOut<1> before = room(kept.before, states.length()), seen = room(kept.seen, states.length());
    const auto alike = [&](Indices<1> others) { return std::equal(states.begin(), states.end(), others.begin()); };
    double error = INFINITY;
    const auto look = [&](Array<1> at) {
        trial_of(problem, r, at, trial);
        project(problem, trial, nearest, states);
        error = error_of(problem.d, at, trial, nearest);
    };
    look(f);
    if (error <= DenseLimits::EXACT && !moves) return true;
    seen.fill(-9);
    for (std::int64_t k = 0; k < rounds; k++) {
        if (!linearised(problem, r, trial, states, force)) return false;
        std::copy(states.begin(), states.end(), before.begin());
        const double last = error;
        look(force);
        if (problem.d < 3 && error < INFINITY && alike(before)) {
            std::copy(force.begin(), force.end(), f.begin());
            return true;
        }
        // Forces that only balance each other show last: it goes on while that makes it better.
        if (error <= DenseLimits::EXACT || (error <= 1.0 && error > 0.5 * last)) {
            std::copy(nearest.begin(), nearest.end(), f.begin());
            return true;
        }
        if (problem.d < 3) {
            if (alike(seen)) return false;  // a cycle
            if ((k & (k + 1)) == 0) std::copy(states.begin(), states.end(), seen.begin());
        }
    }
    return false;
}

// One point ---------------------------------------------------------------------------------------

/// The force at the only point, normal and two tangential, of which those not in d are 0; N.
///
/// Slipping forces solve (S + lambda I) f_t = -p, lambda >= 0, with S and p what W and q leave of the tangential rows
/// when y_n = 0; |f_t| less the radius has one sign at lambda = 0, the other far off, and is halved down.
inline Vec<3> one_point(const DenseProblem& problem) {
    const int d = problem.d;
    const Array<2>& W = problem.W;
    const Array<1>& q = problem.q;
    if (q[0] >= 0) return {};
    // S = ((a, b), (c, e)) and p = (g, h)
    double a = 1.0, b = 0.0, c = 0.0, e = 1.0, g = 0.0, h = 0.0;
    if (d > 1) {
        g = q[1] - W(1, 0) * q[0] / W(0, 0);
        a = W(1, 1) - W(1, 0) * W(0, 1) / W(0, 0);
    }
    if (d > 2) {
        h = q[2] - W(2, 0) * q[0] / W(0, 0);
        b = W(1, 2) - W(1, 0) * W(0, 2) / W(0, 0);
        c = W(2, 1) - W(2, 0) * W(0, 1) / W(0, 0);
        e = W(2, 2) - W(2, 0) * W(0, 2) / W(0, 0);
    }
    double low = 0.0, high = INFINITY, shift = 0.0;
    Vec<3> force{};
    auto& [normal, first, second] = force;
    for (int round = 0; round < DenseLimits::ONE_POINT_HALVINGS; round++) {
        const double determinant = (a + shift) * (e + shift) - b * c;
        normal = -q[0] / W(0, 0);
        first = (b * h - (e + shift) * g) / determinant;
        second = (c * g - (a + shift) * h) / determinant;
        if (d > 1) normal -= W(0, 1) * first / W(0, 0);
        if (d > 2) normal -= W(0, 2) * second / W(0, 0);
        const bool inside = normal > 0 && std::hypot(first, second) <= problem.bounds.radius(0, normal);
        (inside ? high : low) = shift;
        if (inside && (shift == 0.0 || high - low <= 1e-15 * high)) break;
        shift = high == INFINITY ? 4 * shift + a + e : 0.5 * (low + high);
        if (shift == low || shift == high) break;
    }
    return force;
}

/// Writes force and state of the only point; false where the closed form does not hold.
inline bool settle_one_point(const DenseProblem& problem, Output<1> f, IndicesOut<1> states) {
    const auto [normal, first, second] = one_point(problem);
    const double size = std::hypot(first, second);
    const double limit = problem.bounds.radius(0, normal) * (1.0 + BOUND_ROUND_OFF);
    if (!(normal >= 0.0 && size <= limit)) return false;
    f[0] = normal;
    if (problem.d > 1) f[1] = first;
    if (problem.d > 2) f[2] = second;
    states[0] = PointState::OPEN;
    if (normal > 0.0) {
        const std::int64_t slip = problem.d == 2 && first < 0.0 ? -PointState::SLIP : PointState::SLIP;
        states[0] = problem.bounds.at_bound(0, normal, size) ? slip : PointState::STICK;
    }
    return true;
}

// Proximal points ---------------------------------------------------------------------------------

/// Writes W and q of the problem with a term D (f - held), but for the entries of W beside the diagonal, and lengths r.
///
/// D is `softness` times the diagonal of W. Friction follows a normal force by a slope, which makes W larger there:
/// normal parts of D are larger by that of friction, or (`cohesion_only`) of cohesion that is built up, and r smaller.
inline void ease(const DenseProblem& problem, double softness, bool cohesion_only, Array<1> held, Output<2> W,
                 Output<1> q, Output<2> r) {
    const std::ptrdiff_t d = problem.d;
    const auto slope = [&](std::ptrdiff_t i) {
        return problem.bounds[i].line(std::max(held[d * i], 0.0))[0] - (cohesion_only ? problem.bounds.mu[i] : 0.0);
    };
    for (std::ptrdiff_t k = 0; k < q.length(); k++) {
        // Where friction is part of the compliance, the diagonal may be below 0.
        const double added = softness * std::fabs(problem.W(k, k)) * (k % d == 0 ? 1.0 + slope(k / d) : 1.0);
        W(k, k) = problem.W(k, k) + added;
        q[k] = problem.q[k] - added * held[k];
    }
    lengths(d, W, r);
    for (std::ptrdiff_t i = 0; i < r.length(); i++) r(i, 0) /= 1.0 + DenseLimits::FOLLOWED * slope(i);
}

/// The proximal point algorithm, with a term that follows how well Newton's method does.
///
/// The term D (f - f_last) makes the diagonal of W larger for the change of the forces since the last solution. It
/// holds back forces that only balance each other, of which W says next to nothing: Newton's method would throw them
/// about. As the motion settles the term can become smaller, and once it is near the diagonal that makes these forces
/// unique, they settle, too.
inline bool by_proximal_terms(const DenseProblem& problem, bool cohesion_only, Output<1> f, IndicesOut<1> states) {
    static thread_local struct {
        std::vector<double> soft, free, now, trial, nearest, r, own;
    } kept;
    const std::ptrdiff_t size = f.length(), m = states.length();
    const Output<2> soft = room(kept.soft, size, size), r = room(kept.r, m, 2), own = room(kept.own, m, 2);
    const Output<1> free = room(kept.free, size), now = room(kept.now, size);
    const Output<1> trial = room(kept.trial, size), nearest = room(kept.nearest, size);
    const DenseProblem eased{problem.d, soft, free, problem.bounds};
    std::copy(problem.W.begin(), problem.W.end(), soft.begin());
    std::copy(f.begin(), f.end(), now.begin());
    lengths(problem.d, problem.W, own);
    double softness = DenseLimits::SOFTNESS, last = INFINITY;
    for (int round = 0; round < DenseLimits::PROXIMAL_ROUNDS && softness <= DenseLimits::SOFTEST; round++) {
        ease(problem, softness, cohesion_only, now, soft, free, r);
        bool settled = newton(eased, r, now, states, DenseLimits::EASED_ROUNDS, true);
        const bool sharp = settled && softness == 0.0;
        if (!settled) {
            for (std::ptrdiff_t i = 0; i < m; i++) r(i, 0) *= DenseLimits::SHORTER;
            settled = newton(eased, r, now, states, DenseLimits::EASED_ROUNDS, true);
        }
        if (!settled) {
            softness = DenseLimits::SOFTENING * std::max(softness, DenseLimits::HARDEST);
            continue;
        }
        trial_of(problem, own, now, trial);
        project(problem, trial, nearest, states);
        const double error = error_of(problem.d, now, trial, nearest);
        if (error >= 0.5 * last && (sharp || error <= DenseLimits::ENOUGH)) {
            std::copy(now.begin(), now.end(), f.begin());
            return true;
        }
        last = error;
        softness *= DenseLimits::HARDENING;
        if (softness < DenseLimits::HARDEST) softness = 0.0;
    }
    return false;
}

/// The proximal point algorithm from the guess f, and once more from no forces, with another term; f is the answer if
/// it settled.
inline bool by_proximal_points(const DenseProblem& problem, Output<1> f, IndicesOut<1> states) {
    static thread_local std::vector<double> kept;
    if (by_proximal_terms(problem, false, f, states)) return true;
    const Output<1> now = room(kept, f.length());
    now.fill(0.0);
    if (!by_proximal_terms(problem, true, now, states)) return false;
    std::copy(now.begin(), now.end(), f.begin());
    return true;
}

// All of it ---------------------------------------------------------------------------------------

/// Newton's method, then the proximal point algorithm.
///
/// All cohesion at once may lift its own point, and then there is no solution: behind the first try it is built up
/// over the first pressure instead.
inline bool settle(const DenseProblem& problem, Output<1> f, IndicesOut<1> states, IndicesOut<1> counts) {
    static thread_local std::vector<double> kept;
    const std::int64_t m = states.length();
    if (m == 1 && problem.bounds.cohesion[0] == 0.0 && settle_one_point(problem, f, states)) {
        counts[Outcome::NEWTON]++;
        return true;
    }
    const Output<2> r = room(kept, m, 2);
    lengths(problem.d, problem.W, r);
    if (newton(problem, r, f, states, DenseLimits::ROUNDS + 2 * m, false)) {
        counts[Outcome::NEWTON]++;
        return true;
    }
    DenseProblem touching = problem;
    touching.bounds.slope = COHESION_SLOPE;
    if (!by_proximal_points(touching, f, states)) return false;
    counts[Outcome::PROXIMAL]++;
    return true;
}

/// Solves a local problem; false where no method settled it.
///
/// f, (d m,), N, is the guess and becomes the answer; the states, (m,), are left as those of the answer; `counts` are
/// of outcomes. Where no point has friction, tangential rows are dropped.
inline bool solve(int d, Array<2> W, Array<1> q, const PointBounds& bounds, Output<1> f, IndicesOut<1> states,
                  IndicesOut<1> counts) {
    if (!bounds.frictionless()) return settle({d, W, q, bounds}, f, states, counts);
    static thread_local struct {
        std::vector<double> W, q, f;
    } kept;
    const std::ptrdiff_t m = states.length();
    const Output<2> compliance = room(kept.W, m, m);
    const Output<1> free = room(kept.q, m), normal = room(kept.f, m);
    for (std::ptrdiff_t i = 0; i < m; i++) {
        for (std::ptrdiff_t j = 0; j < m; j++) compliance(i, j) = W(d * i, d * j);
        free[i] = q[d * i];
        normal[i] = f[d * i];
    }
    const bool settled = settle({1, compliance, free, bounds}, normal, states, counts);
    f.fill(0.0);
    for (std::ptrdiff_t i = 0; i < m; i++) f[d * i] = normal[i];
    return settled;
}

/// As `solve`, with W (m, d, m, d), q and f (m, d), and the fields of the bounds one by one.
inline bool solve_points(Array<4> W, Array<2> q, Array<1> mu, Array<1> cohesion, double slope, Output<2> f,
                         IndicesOut<1> counts) {
    static thread_local std::vector<std::int64_t> kept;
    const std::ptrdiff_t m = q.length(), d = q.length(1), size = d * m;
    return solve(static_cast<int>(d), {W.data(), {size, size}}, {q.data(), {size}}, {mu, cohesion, slope},
                 {f.data(), {size}}, room(kept, m), counts);
}

}  // namespace rockslip
