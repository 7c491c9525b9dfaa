// What bodies stand on, and what they get from it.
#pragma once

#include "contact.hpp"

namespace rockslip {

/// Mean of the ways of some contacts in a step, m.
template <int d> struct MeanWay {
    Vec<d> sum{};
    int contacts = 0;

    void add(const Vec<d>& way) {
        sum += way;
        contacts++;
    }
    Vec<d> mean() const { return (1.0 / contacts) * sum; }
};

/// What bodies stand on: impulses from it, slip over it, and how deep they are in what they only meet.
template <int d> struct Support {
    std::vector<std::vector<int>> carriers;  // of each body: what its slip is measured over
    std::vector<Vec<d>> slip;             // of each body over what carries it, m; the last is unused
    std::vector<Vec<d>> received;         // impulses of a step on each body from what it stands on, N s
    std::vector<Vec<d>> part_received;    // of a step on the parts of all bodies that have several, one body after another, N s
    std::vector<double> penetration;      // of each body in any but what it carries, m
    std::vector<MeanWay<d>> ways;         // of each body over what carries it in a step, along the axes of that

    void begin(const std::vector<Body<d>>& bodies) {
        carriers.resize(bodies.size());
        slip.assign(bodies.size(), {});
        received.assign(bodies.size(), {});
        penetration.assign(bodies.size(), 0);
        ways.assign(bodies.size(), {});
        for (const Body<d>& body : bodies) {
            first_part_.push_back(body.parts.size() > 1 ? static_cast<int>(part_received.size()) : -1);
            if (body.parts.size() > 1) part_received.resize(part_received.size() + body.parts.size());
        }
    }

    void start_step() {
        for (Vec<d>& each : received) each.fill(0);
        for (Vec<d>& each : part_received) each.fill(0);
        std::fill(penetration.begin(), penetration.end(), 0.0);
    }

    bool carries(int lower, int upper) const {
        const std::vector<int>& below = carriers[upper];
        return std::find(below.begin(), below.end(), lower) != below.end();
    }

    /// Adds a contact that is closed, and its impulses in space, N s.
    void add(const Contact<d>& k, const Vec<d>& force) {
        const int a = k.feature.point_body, b = k.feature.face_body;
        if (first_part_[a] >= 0) part_received[first_part_[a] + k.feature.point_part] += force;
        if (first_part_[b] >= 0) part_received[first_part_[b] + k.feature.face_part] += -1.0 * force;
        const double up = k.axis(0)[d - 1];
        if (bears(b, a, up)) received[a] += force;
        if (bears(a, b, -up)) received[b] += -1.0 * force;
        const double depth = -k.end_gap;
        if (!carries(a, b)) penetration[a] = std::max(penetration[a], depth);
        if (!carries(b, a)) penetration[b] = std::max(penetration[b], depth);
    }

  private:
    static constexpr double STEEPEST = 0.5;  // upward component of the normal of what bears a body

    /// True if a body stands on another one: on what carries it, or by a normal that points upwards.
    bool bears(int lower, int upper, double up) const {
        return carries(lower, upper) || (!carries(upper, lower) && up > STEEPEST);
    }

    std::vector<int> first_part_;  // of each body among those of all; -1: it has one
};

}  // namespace rockslip
