// The friction that points of one interface hold, as arrays.
#pragma once

#include "array.hpp"
#include "friction.hpp"

namespace rockslip {

/// A force this close to its bound, relative to it, is at the bound.
constexpr double BOUND_ROUND_OFF = 1e-9;

/// The tangential forces that m points hold where closed: |f_t| <= mu f_n + min(c, s f_n).
struct PointBounds {
    Array<1> mu, cohesion;    // cohesion c in N (per metre of thickness in the plane), or impulses
    double slope = INFINITY;  // s, how cohesion grows with the force at first; infinite: all at once

    FrictionBound operator[](std::ptrdiff_t point) const { return {mu[point], cohesion[point], slope}; }

    /// Whether no point holds any tangential force.
    bool frictionless() const {
        for (std::ptrdiff_t i = 0; i < mu.length(); i++)
            if (mu[i] > 0 || cohesion[i] > 0) return false;
        return true;
    }

    /// The bound of |f_t| of a point; 0 where it is open.
    double radius(std::ptrdiff_t point, double normal) const {
        if (!(normal > 0)) return 0;
        const auto [slope_there, intercept] = (*this)[point].line(normal);
        return slope_there * normal + intercept;
    }

    /// Whether a closed point holds all the friction that it can: |f_t| is at its bound.
    bool at_bound(std::ptrdiff_t point, double normal, double tangential) const {
        return normal > 0 && tangential >= radius(point, normal) * (1 - BOUND_ROUND_OFF);
    }
};

/// Whether a point at its bound slips, by its way (m), compliance (m/N) and force (N).
inline bool slips(double way, double own, double force) { return way > SLIP_ROUND_OFF * own * force; }

}  // namespace rockslip
