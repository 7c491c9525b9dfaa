// Events inside a step: a touch, an end of slip, a fracture.
#pragma once

#include <set>

#include "step.hpp"

namespace rockslip {

constexpr double BREAKING = 1e-9;  // of the strength of a link: loads this close are at it

/// Speed at which a contact comes together at the start of the step, m/s.
template <int d> double approach(const Step<d>& step, const Contact<d>& k) { return -0.5 * step.moved(k, step.begun)[0]; }

/// True if a contact was clear at the start of the step.
template <int d> bool is_new(const World<d>& world, const Contact<d>& k) { return k.gap > world.touching(); }

/// A contact that was clear and carries an impulse, having come faster than a pull (m/s2) moves in the step;
/// or that touches since the end of the last step, and still comes.
template <int d> bool strikes(const World<d>& world, const Step<d>& step, const Contact<d>& k, double pull) {
    return (is_new(world, k) || !k.was_closed) && k.state != OPEN && k.impulse[0] > 0 && approach(step, k) > 0.5 * step.piece.dt * pull;
}

/// Slip velocities of a contact at the start and the end of the step: by the rows of the start, as
/// those of the middle turn with a pivot, and by the mean over the step.
template <int d> std::array<Vec<d>, 2> slip_velocities(const World<d>& world, const Step<d>& step, const Contact<d>& k) {
    Contact<d> at_start = k;
    step.write_rows_at_start(world, at_start);
    Vec<d> first = 0.5 * step.moved(at_start, step.begun), sum = step.moved(k, step.w);
    first[0] = sum[0] = 0;
    return {first, sum - first};
}

/// Slip velocity below which a contact does not slip, m/s.
template <int d> double slow_slip(const Step<d>& step) { return 1e-3 * step.piece.dt * step.pull; }

/// A contact whose slip turns round in the step.
template <int d> bool reverses(const World<d>& world, const Step<d>& step, const Contact<d>& k) {
    if (k.state == OPEN || is_new(world, k)) return false;
    const double slow = slow_slip(step);
    if (!(0.5 * norm_from(step.moved(k, step.begun), 1) > slow)) return false;
    const auto [first, last] = slip_velocities(world, step, k);
    return norm(first) > slow && dot(first, last) < 0;
}

/// Whether a link is loaded by more than its strength at the end of the step.
template <int d> bool breaks(const Step<d>& step, const Link<d>& link) {
    return link.load(link.measure(step.end[link.a], step.end[link.b])) > (1 + BREAKING) * link.strength;
}

/// Whether something happens at a contact or a link in a step.
template <int d> bool has_event(const World<d>& world, const Step<d>& step, const Contact<d>& k) {
    if (k.link) return step.piece.breaks && breaks(step, *k.link->link);
    return strikes(world, step, k, step.pull) || reverses(world, step, k);
}

/// Whether something happens in a step.
template <int d> bool has_event(const World<d>& world, const Step<d>& step) {
    const auto happens = [&](const Contact<d>& k) { return has_event(world, step, k); };
    return std::any_of(step.contacts.begin(), step.contacts.end(), happens) || std::any_of(step.links.begin(), step.links.end(), happens);
}

/// How many bodies move at one of their contacts faster than weight accelerates in half of the step.
template <int d> int moving_bodies(const World<d>& world, const Step<d>& step) {
    std::set<int> moving;
    for (const Contact<d>& k : step.contacts) {
        if (!(norm(step.moved(k, step.begun)) > step.piece.dt * step.pull)) continue;
        for (int b : {k.feature.point_body, k.feature.face_body})
            if (world.bodies[b].moves()) moving.insert(b);
    }
    return static_cast<int>(moving.size());
}

/// Whether a link breaks in a step.
template <int d> bool has_fracture(const World<d>& world, const Step<d>& step) {
    return std::any_of(step.links.begin(), step.links.end(), [&](const Contact<d>& k) { return has_event(world, step, k); });
}

}  // namespace rockslip
