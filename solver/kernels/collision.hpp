// Collisions: two bodies that met at an instant, by the contacts between them that came together.
#pragma once

#include "contact.hpp"

namespace rockslip {

/// Two bodies that met at an instant, over all points at which they did.
template <int d> struct Collision {
    double time = 0;         // s
    int a = 0, b = 0;        // a < b
    int points = 0;
    Vec<d> place{};          // mean of the points by their normal impulses, m
    Vec<d> normal{};         // mean, likewise, from b to a
    double approach = 0;     // largest normal velocity before, m/s
    double departure = 0;    // and the largest after
    double brought = 0;      // part of the approach that a brings, where it is largest, m/s
    Turn<d> spin{};          // of a against b before, in space, rad/s
    Turn<d> later_spin{};    // and after; nan where a step was not cut there
    Vec<d> impulse{};        // on a, N s
    double energy = 0;       // lost by the impulses of this pair, J
};

/// A contact that came together, and what it did then.
template <int d> struct Encounter {
    const Contact<d>& contact;
    Vec<d> place;              // m
    Vec<d> before, after;      // normal velocity, and along the tangents, m/s
    double own;                // part of the approach that the body of the point brings, m/s
    Turn<d> spin, later_spin;  // of that body against the other, in space, rad/s
};

/// The collisions of one instant, pair by pair.
template <int d> class InstantCollisions {
  public:
    explicit InstantCollisions(double when) : when_(when) {}

    /// Adds a contact that came together to the collision of its pair.
    void add(const Encounter<d>& point) {
        const Contact<d>& k = point.contact;
        const Vec<d>& before = point.before;
        if (!of(k)) {
            const auto [a, b] = std::minmax(k.feature.point_body, k.feature.face_body);
            found_.emplace_back();
            found_.back().time = when_;
            found_.back().a = a;
            found_.back().b = b;
        }
        Collision<d>& met = *of(k);
        const double sign = k.feature.point_body == met.a ? 1 : -1, old = sign * dot(met.impulse, met.normal);
        const double share = k.impulse[0] / (k.impulse[0] + std::fabs(old));
        met.points++;
        met.place = (1 - share) * met.place + share * point.place;
        met.normal = (1 - share) * met.normal + (share * sign) * k.axis(0);
        if (-before[0] > met.approach) met.brought = sign > 0 ? point.own : -before[0] - point.own;
        met.approach = std::max(met.approach, -before[0]);
        met.departure = std::max(met.departure, point.after[0]);
        met.spin = sign * point.spin;
        met.later_spin = sign * point.later_spin;
        add_impulse(k, before + point.after);
    }

    /// Adds the impulse of a contact to the collision of its pair, if that collided, by the sum of its velocities
    /// before and after.
    void add_impulse(const Contact<d>& k, const Vec<d>& speeds) {
        Collision<d>* met = of(k);
        if (!met) return;
        const double sign = k.feature.point_body == met->a ? 1 : -1;
        for (int i = 0; i < d; i++) met->impulse += (sign * k.impulse[i]) * k.axis(i);
        met->energy -= 0.5 * dot(k.impulse, speeds);
    }

    void append_to(std::vector<Collision<d>>& all) const { all.insert(all.end(), found_.begin(), found_.end()); }

  private:
    /// The collision of the pair of a contact; none: nullptr.
    Collision<d>* of(const Contact<d>& k) {
        const auto [a, b] = std::minmax(k.feature.point_body, k.feature.face_body);
        for (Collision<d>& each : found_)
            if (each.a == a && each.b == b) return &each;
        return nullptr;
    }

    double when_;
    std::vector<Collision<d>> found_;
};

}  // namespace rockslip
