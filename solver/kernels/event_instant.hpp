// The instant of an event: the length of the step at whose end it happens, by solving the step at other lengths.
#pragma once

#include "event.hpp"
#include "step_solver.hpp"

namespace rockslip {

constexpr double AT_END = 1e-9;  // of a step: events this close to its ends are there

/// Regula falsi (Illinois) for a value that falls from positive to negative.
struct Bracket {
    double at_low;     // at a step without length, to begin with
    double tolerance;  // what of the value counts as zero
    double low = 0, high = INFINITY, at_high = 0;
    int side = 0;

    void narrow(double length, double value) {
        const int now = value > 0 ? 1 : -1;
        if (now > 0) {
            low = length;
            at_low = value;
            if (side == now) at_high *= 0.5;
        } else {
            high = length;
            at_high = value;
            if (side == now) at_low *= 0.5;
        }
        side = now;
    }
    /// The next length to try; infinite where the value has not been negative.
    double root() const { return high < INFINITY ? low + (high - low) * at_low / (at_low - at_high) : INFINITY; }
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
    double length = step.piece.dt;
    for (int round = 0; round < 30; round++) {
        if (round > 0 && !solver.solve_length(step, length)) break;
        bool reached = false, passed = false;
        double next = INFINITY;
        for (std::size_t i = 0; i < brackets.size(); i++) {
            const double left = value(i);
            reached |= left <= brackets[i].tolerance;
            passed |= left < -brackets[i].tolerance;
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
template <int d> double locate_end_of_slip(const World<d>& world, StepSolver<d>& solver, Step<d>& step) {
    const Contact<d>* first = nullptr;
    double soonest = INFINITY, speed = 0;
    for (const Contact<d>& k : step.contacts) {
        if (!reverses(world, step, k)) continue;
        const auto [begin, end] = slip_velocities(world, step, k);
        const double when = dot(begin, begin) / (dot(begin, begin) - dot(begin, end));
        if (when < soonest) {
            soonest = when;
            first = &k;
            speed = norm(begin);
        }
    }
    if (!first) return 0;
    const double dt = step.piece.dt, shortest = 1e-3 * dt;
    const auto [length, found] = first_zero(solver, step, {{speed, 1e-6 * speed}}, shortest, [&](std::size_t) {
        const auto [begin, end] = slip_velocities(world, step, *first);
        return dot(begin, end) / speed;
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
