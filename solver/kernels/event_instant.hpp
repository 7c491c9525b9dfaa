// The instant of an event: the length of the step at whose end it happens, by solving the step at other lengths.
#pragma once

#include "event.hpp"
#include "step_solver.hpp"

namespace rockslip {

constexpr double AT_END = 1e-9;  // of a step: events this close to its ends are there

/// The root of a value that falls from positive to negative: by the secant of the last two lengths while that goes on in
/// smaller steps between lengths of both signs, else in their middle (Dekker 1969).
struct Bracket {
    double at_last;    // at a step without length, to begin with
    double tolerance;  // what of the value counts as zero
    double high = INFINITY, low = 0, last = 0, secant = 0;
    double step = INFINITY, before = INFINITY;  // between the last lengths, and between those before

    void narrow(double length, double value) {
        (value > 0 ? low : high) = length;
        secant = length - value * (length - last) / (value - at_last);
        before = step;
        if (last > 0) step = std::fabs(length - last);
        last = length;
        at_last = value;
    }
    /// The next length to try; infinite where the value has not been negative.
    double root() const {
        if (!(high < INFINITY)) return INFINITY;
        return low < secant && secant < high && std::fabs(secant - last) < before ? secant : 0.5 * (low + high);
    }
};

/// The length of a step, s, and whether it is the one that was looked for.
struct Located {
    double length;
    bool found;
};

/// The length of a step at whose end the first of some values is zero; it is then solved. `value` has them, by their
/// numbers, for the step as solved; lengths below the shortest, s, are not tried.
template <int d, class Value>
Located first_zero(StepSolver<d>& solver, Step<d>& step, std::vector<Bracket> brackets, double shortest, Value value) {
    constexpr int ROUNDS = 20, EXACT = 8;  // after so many rounds it is the error of solved steps that hides a zero
    double length = step.piece.dt;
    for (int round = 0; round < ROUNDS; round++) {
        if (round > 0 && !solver.solve_length(step, length)) break;
        bool reached = false, passed = false;
        double next = INFINITY;
        for (std::size_t i = 0; i < brackets.size(); i++) {
            const double left = value(i), zero = std::exp2(std::max(round - EXACT, 0)) * brackets[i].tolerance;
            reached |= left <= zero;
            passed |= left < -zero;
            brackets[i].narrow(length, left);
            next = std::min(next, brackets[i].root());
        }
        if (reached && !passed) return {length, true};
        if (!(next < INFINITY) || next < shortest) break;
        length = next;
    }
    return {length, false};
}

/// Length of the step at whose end the first contact touches; it is then solved without those that
/// were clear. 0 where there is none.
template <int d> double locate_touch(const World<d>& world, StepSolver<d>& solver, Step<d>& step) {
    std::vector<Contact<d>> clear, touching;
    std::vector<Bracket> gaps;
    for (const Contact<d>& k : step.contacts) (is_new(world, k) ? clear : touching).push_back(k);
    gaps.reserve(clear.size());
    for (const Contact<d>& k : clear) gaps.push_back({k.gap, world.round_off()});
    step.contacts.swap(touching);
    const double dt = step.piece.dt;
    if (!solver.solve_length(step, dt)) return 0;
    const auto [length, found] = first_zero(solver, step, gaps, 0, [&](std::size_t i) { return step.end_gap(world, clear[i].feature); });
    if (!found) return 0;
    if (length < (1 - AT_END) * dt) return length;
    return solver.solve_length(step, dt) ? dt : 0;
}

/// Length of the step at whose end the first slip stops; it is then solved. 0 where there is none.
///
/// A slip that stops early has turned round where the step is long: it sticks over the step as a whole, however long
/// that is. How it slows down shows in a short step.
template <int d> double locate_end_of_slip(const World<d>& world, StepSolver<d>& solver, Step<d>& step) {
    const double dt = step.piece.dt, shortest = 1e-3 * dt, slow = slow_slip(step);
    std::vector<const Contact<d>*> slipping;
    std::vector<Bracket> speeds;
    for (const Contact<d>& k : step.contacts) {
        if (k.state == OPEN || is_new(world, k)) continue;
        const auto [begin, end] = slip_velocities(world, step, k);
        const double speed = norm(begin);
        if (!(speed > slow)) continue;
        slipping.push_back(&k);
        speeds.push_back({speed, std::max(1e-6 * speed, 1e-2 * slow), dot(begin, end) < 0 ? dt : INFINITY});
    }
    if (!solver.solve_length(step, shortest)) return 0;
    const auto [length, found] = first_zero(solver, step, speeds, shortest, [&](std::size_t i) {
        const auto [begin, end] = slip_velocities(world, step, *slipping[i]);
        return dot(begin, end) / norm(begin);
    });
    return found && length > shortest && length < (1 - 1e-3) * dt ? length : 0;
}

/// Length of the step at whose end the first of some links, by their numbers, breaks, as near as it is found; 0 where
/// it does at once.
template <int d> double locate_fracture(const World<d>& world, StepSolver<d>& solver, Step<d>& step, const std::vector<int>& breaking) {
    std::vector<Bracket> strength_left;
    for (int i : breaking) {
        const Link<d>& link = world.links[i];
        const double left = link.strength - link.load(link.extension);
        if (!(left > 0)) return 0;
        strength_left.push_back({left, BREAKING * link.strength});
    }
    return first_zero(solver, step, strength_left, 0, [&](std::size_t i) {
               const Link<d>& link = world.links[breaking[i]];
               return link.strength - link.load(link.measure(step.end[link.a], step.end[link.b]));
           }).length;
}

}  // namespace rockslip
