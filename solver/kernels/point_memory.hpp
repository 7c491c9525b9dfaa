// What points remember of a step, and the energy that is stored and lost in their interface.
#pragma once

#include <tuple>

#include "point_friction.hpp"

namespace rockslip {

/// The forces of all points of an interface and where they are, at one end of a step.
struct PointsAtEnd {
    Array<2> force;  // (points, d), N: normal, tangential
    Array<2> y;      // augmented positions, (points, d), m
};

/// Fills in stick memories, (points, d-1), m, and pasts after a step of a length, s; returns what friction
/// and contact took, J.
///
/// Friction is minus the work of the tangential forces on the anchors. Contact takes the work of the forces
/// against y that is neither stored in their softness, (points,), m/N, nor lost in friction. Whether a point
/// slips is told by its `own` compliance, (points,), m/N.
inline std::tuple<double, double> after_step(const PointsAtEnd& at, const PointsAtEnd& before, Array<2> old_anchor,
                                             const PointPasts<const double>& old_past, Array<1> softness,
                                             Array<1> own, const PointBounds& bounds, double step, Output<2> anchor,
                                             const PointPasts<double>& past) {
    double friction = 0, contact = 0;
    for (std::ptrdiff_t p = 0; p < at.force.length(); p++) {
        const Array<1> f = at.force[p], y = at.y[p], old_f = before.force[p], old_y = before.y[p];
        for (std::ptrdiff_t k = 0; k < f.length(); k++) {
            const double grown = f[k] - old_f[k], both = f[k] + old_f[k];
            contact -= f[k] * (y[k] - old_y[k]) + 0.5 * softness[p] * grown * both;
        }
        const bool closed = f[0] > 0;
        double squares = 0;
        for (std::ptrdiff_t k = 1; k < f.length(); k++) {
            anchor(p, k - 1) = y[k] + (closed ? softness[p] * f[k] : 0.0);
            const double slip = anchor(p, k - 1) - old_anchor(p, k - 1);
            friction -= f[k] * slip;
            squares += slip * slip;
        }
        const double way = std::sqrt(squares);
        const bool slips = closed && slips_in_step(bounds, p, f, way, own[p]);
        past.write(p, remembered(old_past[p], way / step, slips));
    }
    return {friction, contact - friction};
}

/// Energy of an interface whose points have tractions T, (points, d), Pa: the sum of
/// (f^2/w - theta w T^2)/(2 gamma_h), J, by softness 1/(gamma_h w), m/N, weight w and 1/gamma_h, m/Pa.
inline double stored_energy(Array<2> force, Array<2> traction, Array<1> softness, Array<1> weight,
                            Array<1> inverse_gamma, double theta) {
    double energy = 0;
    for (std::ptrdiff_t p = 0; p < force.length(); p++)
        for (std::ptrdiff_t k = 0; k < force.length(1); k++) {
            const double f = force(p, k), T = traction(p, k);
            energy += 0.5 * softness[p] * (f * f);
            energy -= 0.5 * theta * weight[p] * inverse_gamma[p] * (T * T);
        }
    return energy;
}

/// Weighted sum of the squared changes of vectors, (points, d).
inline double squared_change(Array<1> weight, Array<2> before, Array<2> after) {
    double total = 0;
    for (std::ptrdiff_t p = 0; p < before.length(); p++)
        for (std::ptrdiff_t k = 0; k < before.length(1); k++) {
            const double change = after(p, k) - before(p, k);
            total += weight[p] * (change * change);
        }
    return total;
}

/// The forces of all points of an interface, (points, d), N, and what these remember, at one end of a step.
struct InterfaceState {
    Array<2> force;
    PointPasts<const double> past;

    bool closed(std::ptrdiff_t point) const { return force(point, 0) > 0; }

    /// Whether all closed points slip.
    bool all_slip() const {
        for (std::ptrdiff_t p = 0; p < force.length(); p++)
            if (closed(p) && !past[p].slipped) return false;
        return true;
    }

    /// Size of a point's force, N.
    double size(std::ptrdiff_t point) const {
        double size = 0;
        for (const double part : force[point]) size = std::hypot(size, part);
        return size;
    }
};

/// Forces of the points that opened, closed, stuck, slipped or turned round in a step, and of all, N: of
/// each point the larger one of both ends.
///
/// `rigid`: neither body is meshed. Which of their points slip is then chance, unless all of them do.
inline std::tuple<double, double> changed_forces(const InterfaceState& before, const InterfaceState& after,
                                                 bool rigid) {
    double shaken = 0, carried = 0;
    const bool together_before = !rigid || before.all_slip();
    const bool together_after = !rigid || after.all_slip();
    for (std::ptrdiff_t p = 0; p < before.force.length(); p++) {
        const bool slipped = together_before && before.past[p].slipped && (!rigid || before.closed(p));
        const bool slips = together_after && after.past[p].slipped && (!rigid || after.closed(p));
        double turned = 0;
        for (std::ptrdiff_t k = 1; k < before.force.length(1); k++)
            turned += before.force(p, k) * after.force(p, k);
        const bool changed = before.closed(p) != after.closed(p) || slipped != slips || (slipped && turned < 0);
        const double larger = std::max(before.size(p), after.size(p));
        carried += larger;
        if (changed) shaken += larger;
    }
    return {shaken, carried};
}

}  // namespace rockslip
