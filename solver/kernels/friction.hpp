// Coulomb's law with cohesion, and the projection on the impulses that it admits.
//
// A closed point holds the shear stress tau = c + mu p. The coefficient falls from its static to its
// dynamic value with the speed v of sliding,
//
//     mu = mu_d + (mu_s - mu_d) exp(-DC v),                                               (M26)
//
// or, where DC = 0, as soon as the point has slipped.
#pragma once

#include "linear.hpp"

namespace rockslip {

/// The law of a pair of surfaces; the fields are those of the tables of a scene.
struct ContactLaw {
    double static_friction = 0;   // mu_s
    double dynamic_friction = 0;  // mu_d
    double decay = 0;             // DC, s/m; 0: the coefficient jumps when a point slips
    double cohesion = 0;          // c, Pa: what a closed point holds without pressure
    bool loses_cohesion = false;  // a point that broke loose has no cohesion any more
    double restitution = 0;       // e; 0: what lands does not rebound

    /// Coefficient at a speed (m/s), or where DC = 0 by whether the point slipped.
    double coefficient(double speed, bool slipped) const {
        if (decay > 0) return dynamic_friction + (static_friction - dynamic_friction) * std::exp(-decay * speed);
        return slipped ? dynamic_friction : static_friction;
    }

    /// Coefficient by the motion that `mu` led to: the speed of slip in this step, m/s, 0 where the point
    /// sticks, and whether it broke loose in it. Without decay it only falls, from mu_s to mu_d: no choice
    /// between the two can then repeat itself.
    double followed(double mu, double speed, bool slips) const {
        if (decay > 0) return coefficient(speed, slips);
        return slips ? dynamic_friction : mu;
    }

    /// Whether a point has its cohesion, by whether it ever broke loose.
    bool coheres(bool broken) const { return !(loses_cohesion && broken); }
};

/// What a contact remembers of its friction.
struct FrictionHistory {
    double rate = 0;       // slip rate in the last step, m/s; 0 where it stuck
    bool slipped = false;  // in the last step
    bool broken = false;   // ever broke loose
};

/// The bound of a contact: |P_t| <= mu P_n + min(c, s P_n) where P_n > 0.
struct FrictionBound {
    double mu = 0;
    double cohesion = 0;     // c, N s
    double slope = INFINITY;  // s: how cohesion grows with P_n at first; infinite: all at once

    /// Derivative of the bound and its value at P_n = 0, at a normal impulse > 0.
    std::array<double, 2> line(double normal) const {
        if (slope * normal < cohesion) return {mu + slope, 0.0};
        return {mu, cohesion};
    }

    /// The bound over a normal impulse > 0.
    double secant(double normal) const { return mu + std::min(slope, cohesion / normal); }
};

/// All cohesion at once may lift its own point, and no impulse then obeys the law: it is built up
/// over the first 1e-4 of the pressure instead.
constexpr double COHESION_SLOPE = 1e4;

/// A contact at its bound slips where it moves by more than this part of what its own impulse moves
/// it by; less only settles which of several points of a rigid body holds how much.
constexpr double SLIP_ROUND_OFF = 1e-5;

/// A step starts with the friction that the past of a contact leaves it; `area_time` in m2 s.
inline FrictionBound bound_at_start(const ContactLaw& law, const FrictionHistory& past, double area_time) {
    const double cohesion = law.coheres(past.broken) ? law.cohesion * area_time : 0.0;
    return {law.coefficient(past.rate, past.slipped), cohesion, INFINITY};
}

/// Brings the bound up to the slip that it led to; returns whether that changed it.
///
/// By speed and slip as in `ContactLaw::followed`; with decay the coefficient goes a `share` of the way.
inline bool follow_slip(const ContactLaw& law, FrictionBound& bound, double speed, bool slips, double share) {
    const FrictionBound before = bound;
    const double next = law.followed(bound.mu, speed, slips);
    bound.mu = law.decay > 0 ? bound.mu + share * (next - bound.mu) : next;
    if (!law.coheres(slips)) bound.cohesion = 0;
    return std::fabs(bound.mu - before.mu) > 1e-13 || bound.cohesion != before.cohesion;
}

/// Friction that falls with speed follows it all the way in so many rounds, then half the way, at last not at all.
constexpr std::array<double, 3> FRICTION_SHARES{1.0, 0.5, 0.0};
constexpr int FRICTION_ROUNDS = 40;

/// Friction's share of the kinetic energy that a correction takes, J.
///
/// The tangential impulses took `tangential`, all of them `lost`, and friction had `taken` in the step before.
/// Normal and tangential impulses of a body act on each other: the work in one direction may be negative, though
/// their sum is a loss. Friction returns no more than it took before: what the tangential impulses give back
/// beyond that, the normal ones took, and it is contact's.
inline double friction_share(double tangential, double lost, double taken) {
    return std::min(std::max(tangential, -taken), std::max(lost, -taken));
}

enum State { OPEN, STICK, SLIP, SLIP_BACK, GIVEN };  // SLIP_BACK in the plane: towards -t

/// How the friction of a contact is found.
enum class FrictionMode {
    LAW,       // |P_t| <= bound, opposite to slip at the bound
    AT_BOUND,  // in a given direction, with the size of the bound
    FIXED,     // given
};

/// The admissible impulse nearest to a trial, normal part first, then the disc (Alart and Curnier
/// 1991); its derivative, where wanted; and the state that it stands for.
template <int d>
Vec<d> project(const FrictionBound& bound, FrictionMode mode, const Vec<d>& given, const Vec<d>& trial,
               State& state, Mat<d, d>* derivative) {
    Vec<d> p{};
    if (derivative) *derivative = {};
    if (mode == FrictionMode::FIXED)
        for (int i = 1; i < d; i++) p[i] = given[i];
    state = OPEN;
    if (!(trial[0] > 0)) return p;
    p[0] = trial[0];
    if (derivative) (*derivative)[0][0] = 1;
    const auto [slope, intercept] = bound.line(trial[0]);
    const double limit = slope * trial[0] + intercept;
    if (mode != FrictionMode::LAW) {
        state = GIVEN;
        if (mode == FrictionMode::AT_BOUND)
            for (int i = 1; i < d; i++) {
                p[i] = limit * given[i];
                if (derivative) (*derivative)[i][0] = slope * given[i];
            }
        return p;
    }
    const double size = norm_from(trial, 1);
    if (size <= limit && limit > 0) {
        state = STICK;
        for (int i = 1; i < d; i++) {
            p[i] = trial[i];
            if (derivative) (*derivative)[i][i] = 1;
        }
        return p;
    }
    state = d == 2 && trial[1] < 0 ? SLIP_BACK : SLIP;
    if (!(size > 0)) return p;
    for (int i = 1; i < d; i++) {
        const double e = trial[i] / size;
        p[i] = limit * e;
        if (!derivative) continue;
        (*derivative)[i][0] = slope * e;
        if (d == 3)
            for (int j = 1; j < d; j++) (*derivative)[i][j] = limit / size * ((i == j) - e * trial[j] / size);
    }
    return p;
}

}  // namespace rockslip
