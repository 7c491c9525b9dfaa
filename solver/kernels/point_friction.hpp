// What the points of one interface hold by friction, and what they remember of it, as arrays.
#pragma once

#include "point_bounds.hpp"

namespace rockslip {

/// What points remember of their friction, (m, 3): the entries RATE, SLIPPED and BROKEN of
/// `solver.law.friction`.
template <class T> struct PointPasts {
    View<T, 2> rows;

    FrictionHistory operator[](std::ptrdiff_t point) const {
        return {rows(point, 0), rows(point, 1) > 0, rows(point, 2) > 0};
    }
    void write(std::ptrdiff_t point, const FrictionHistory& past) const {
        rows(point, 0) = past.rate;
        rows(point, 1) = past.slipped;
        rows(point, 2) = past.broken;
    }
};

/// What a point remembers after a step, by its speed of slip in it, m/s, and whether it slipped: one that
/// is open has not.
inline FrictionHistory remembered(const FrictionHistory& past, double speed, bool slips) {
    return {slips ? speed : 0.0, slips, past.broken || slips};
}

/// Size of the tangential part of a point's force, N.
inline double tangential_size(Array<1> force) {
    double squares = 0;
    for (std::ptrdiff_t k = 1; k < force.length(); k++) squares += force[k] * force[k];
    return std::sqrt(squares);
}

/// Whether the friction of a closed point is at its bound, by its force, N.
inline bool at_bound(const PointBounds& bounds, std::ptrdiff_t point, Array<1> force) {
    return bounds.at_bound(point, force[0], tangential_size(force));
}

/// Whether a point slips in a step: at its bound, and moved by more than round-off.
///
/// By its force, N, the way that it moved along its carrier from where it stuck, m, and its own
/// compliance, m/N; cohesion counts as far as the force has built it up.
inline bool slips_in_step(const PointBounds& bounds, std::ptrdiff_t point, Array<1> force, double way, double own) {
    if (!at_bound({bounds.mu, bounds.cohesion, COHESION_SLOPE}, point, force)) return false;
    double largest = 0;
    for (const double part : force) largest = std::max(largest, std::fabs(part));
    return slips(way, own, largest);
}

/// The points that slip in a step, by their forces (m, d), N, slips (m, d-1), m, and own compliances, m/N.
inline void slipping_points(Array<2> force, Array<2> slip, Array<1> own, const PointBounds& bounds,
                            MaskOut<1> found) {
    for (std::ptrdiff_t i = 0; i < force.length(); i++) {
        double squares = 0;
        for (const double part : slip[i]) squares += part * part;
        found[i] = slips_in_step(bounds, i, force[i], std::sqrt(squares), own[i]);
    }
}

/// Coefficients and cohesion (N) of points when a step begins, by what they remember and their areas, m2.
inline void bounds_by_past(const ContactLaw& law, const PointPasts<const double>& past, Array<1> area, Output<1> mu,
                           Output<1> cohesion) {
    for (std::ptrdiff_t i = 0; i < area.length(); i++) {
        const FrictionBound bound = bound_at_start(law, past[i], area[i]);
        mu[i] = bound.mu;
        cohesion[i] = bound.cohesion;
    }
}

/// The same within a step, by coefficients so far, speeds (m/s) and slips in it.
inline void bounds_followed(const ContactLaw& law, const PointPasts<const double>& past, Array<1> area, Array<1> so_far,
                            Array<1> speed, Mask<1> slips, Output<1> mu, Output<1> cohesion) {
    for (std::ptrdiff_t i = 0; i < area.length(); i++) {
        mu[i] = law.followed(so_far[i], speed[i], slips[i]);
        cohesion[i] = law.coheres(slips[i] || past[i].broken) ? law.cohesion * area[i] : 0.0;
    }
}

}  // namespace rockslip
