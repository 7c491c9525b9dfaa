// Which points of a block touch what carries it, how they have slipped and how deep they are in it.
#pragma once

#include "array.hpp"
#include "linear.hpp"

namespace rockslip {

/// Points of an interface by their forces, N, and places, m, (n, d), normal part first, and by which of them
/// may touch.
struct TouchingPoints {
    Array<2> force, place;
    Mask<1> may_touch;
    double level;  // points within it of the lowest one are as low, m

    /// Calls a function for the closed points, or else for the lowest one and all that are as low; where no
    /// point may touch, for all. Returns for how many.
    template <class F> std::ptrdiff_t each(F touched) const {
        std::ptrdiff_t closed = 0;
        for (std::ptrdiff_t p = 0; p < force.length(); p++)
            if (force(p, 0) > 0) {
                touched(p);
                closed++;
            }
        if (closed > 0) return closed;
        double lowest = INFINITY;
        for (std::ptrdiff_t p = 0; p < place.length(); p++) lowest = std::min(lowest, height(p));
        for (std::ptrdiff_t p = 0; p < place.length(); p++)
            if (height(p) <= lowest + level) {
                touched(p);
                closed++;
            }
        return closed;
    }

    /// Fills in the mean slip (d - 1,), m, from reference positions (n, d - 1).
    void mean_slip(const Array<2>& reference, const Output<1>& slip) const {
        slip.fill(0);
        const std::ptrdiff_t count = each([&](std::ptrdiff_t p) {
            for (std::ptrdiff_t j = 0; j < slip.length(); j++) slip[j] += place(p, 1 + j) - reference(p, j);
        });
        for (double& part : slip) part /= static_cast<double>(count);
    }

  private:
    double height(std::ptrdiff_t p) const { return may_touch[p] ? place(p, 0) : INFINITY; }
};

/// Largest penetration of points by their places, (n, d), and which of them are over their carrier, m; 0 if
/// none penetrates.
inline double penetration(const Array<2>& place, const Mask<1>& inside) {
    double deepest = 0;
    for (std::ptrdiff_t p = 0; p < place.length(); p++)
        if (inside[p] && place(p, 0) < deepest) deepest = place(p, 0);
    return 0 - deepest;
}

}  // namespace rockslip
