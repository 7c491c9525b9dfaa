// A platform on a spring and a dashpot, which moves along the horizontal directions alone.
#pragma once

#include "body.hpp"
#include "ledger.hpp"

namespace rockslip {

/// Parameters of generalized-alpha, which only the spring of a platform needs.
struct Scheme {
    double alpha_m = 0, alpha_f = 0.5, beta = 0.5;
};

/// Writes the effective mass of a platform on its spring and its motion without contacts, for a step of dt, by the
/// mean acceleration of gravity less that of the ground (M57).
template <int d>
void set_platform(const Body<d>& body, const Scheme& scheme, const Vec<d>& acceleration, double dt, Motion<d>& free,
                  MotionMatrix<d>& mass, MotionMatrix<d>& inverse_mass) {
    const double weight = 0.5 * (1 - scheme.alpha_m) / scheme.beta;
    const double inertial = (1 - scheme.alpha_m) / (scheme.beta * dt * dt) * body.mass;
    const double stiffness = inertial + (1 - scheme.alpha_f) * body.stiffness + weight * body.damping / dt;
    const double later = (1 - scheme.alpha_m) * (0.5 / scheme.beta - 1) - scheme.alpha_m;
    const Vec<d> load = body.mass * acceleration;
    free.fill(0);
    for (int i = 0; i + 1 < d; i++) {
        const double right = weight * load[i] - body.stiffness * body.x[i] + inertial * dt * body.v[i] + later * body.spring_force[i];
        free[i] = 2 / dt * right / stiffness;
        inverse_mass[i][i] = 2 / (dt * dt) * weight / stiffness;
        mass[i][i] = 1 / inverse_mass[i][i];
    }
}

/// Spring force of a platform after a way du, the losses of dashpot and averaging, and the impulse on the ground.
///
/// (1 - alpha_m) p_{n+1} + alpha_m p_n + k u_alpha = 0 (M6); averaging (M15) takes (1/2 - alpha_f) du dr with
/// r = p + k u.
template <int d>
void take_platform(Body<d>& body, const Scheme& scheme, const Vec<d>& du, double dt, Ledger& ledger, Vec<d>& ground_impulse) {
    const double k = body.stiffness, c = body.damping;
    for (int i = 0; i + 1 < d; i++) {
        const double p = body.spring_force[i];
        const double next = -(k * (body.x[i] + (1 - scheme.alpha_f) * du[i]) + scheme.alpha_m * p) / (1 - scheme.alpha_m);
        ledger.damping += c * du[i] * du[i] / dt;
        ledger.numerical += (0.5 - scheme.alpha_f) * du[i] * (next - p + k * du[i]);
        const double late = 2 * scheme.beta;
        ground_impulse[i] += c * du[i] - dt * (late * next + (1 - late) * p);
        body.spring_force[i] = next;
    }
}

}  // namespace rockslip
