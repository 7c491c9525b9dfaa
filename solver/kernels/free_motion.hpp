// The motion of a free body by its inertia, gravity and applied forces.
#pragma once

#include "step.hpp"

namespace rockslip {

/// By how much the turn of a body in a step is off, an iterate of Newton's method for the energy-momentum rule on the
/// angular momentum (Simo and Wong 1991), (M56).
///
/// Takes the inertia and the spin about the body's own axes, the rotation at the start; the sum of the spins at both
/// ends so far, and the moments that act, in space, both over the step of dt: N m s.
inline Vec<3> turn_correction(const Mat<3, 3>& J, const Vec<3>& spin, const Mat<3, 3>& R, const Vec<3>& turn, const Vec<3>& given, double dt) {
    const Vec<3> psi = to_body(R, 0.5 * dt * turn), moment = to_body(R, dt * given);
    const Vec<3> rule = 2.0 * mul(J, psi - dt * spin) + cross(psi, mul(J, psi));
    Vec<3> change = moment - 0.5 * cross(psi, moment) - rule;
    const Vec<3> momentum = mul(J, psi) + 0.5 * moment;
    LU<3> tangent;
    for (int j = 0; j < 3; j++) {
        Vec<3> unit{}, column;
        unit[j] = 1;
        for (int i = 0; i < 3; i++) column[i] = J[i][j];
        column = 2.0 * column + cross(psi, column) - cross(momentum, unit);
        for (int i = 0; i < 3; i++) tangent.a[i][j] = column[i];
    }
    if (tangent.factorize()) tangent.solve(change);
    else change.fill(NAN);
    return to_space(R, (2 / dt) * change);
}

/// Impulses and moments of the applied forces on a body in a step, by their means over it.
template <int d> Motion<d> applied_impulse(const World<d>& world, const Step<d>& step, int b) {
    const double dt = step.piece.dt;
    Motion<d> pushed{};
    for (int i : world.forces_on[b]) {
        const Vec<d> force = step.mean_force(world, world.forces[i]);
        const auto turn = moment(mul(mean(step.start[b].at.R, step.end[b].R), world.forces[i].arm), force);
        for (int j = 0; j < d; j++) pushed[j] += dt * force[j];
        for (int j = 0; j < Dim<d>::rotations; j++) pushed[d + j] += dt * turn[j];
    }
    return pushed;
}

/// Motion of a free body without contacts, for M (w - w_free) = its impulses and moments by them; in space about the
/// last iterate and what contacts did to it, `touched`.
template <int d> Motion<d> free_motion(const World<d>& world, const Step<d>& step, int b, const Motion<d>& touched) {
    const Body<d>& body = world.bodies[b];
    const Motion<d> pushed = applied_impulse(world, step, b);
    Motion<d> free = mul(step.inverse_mass[b], pushed);
    for (int i = 0; i < d; i++) free[i] += 2 * body.v[i] + step.piece.dt * step.load[i];
    if constexpr (d == 2) {
        free[2] += 2 * body.spin[0];
    } else {
        const Vec<3> turn{step.w[b][3], step.w[b][4], step.w[b][5]};
        const Vec<3> given{touched[3] + pushed[3], touched[4] + pushed[4], touched[5] + pushed[5]};
        const Vec<3> change = turn_correction(body.inertia, body.spin, step.start[b].at.R, turn, given, step.piece.dt);
        for (int i = 0; i < 3; i++) {
            free[3 + i] = turn[i] + change[i];
            for (int j = 0; j < 3; j++) free[3 + i] -= step.inverse_mass[b][3 + i][3 + j] * touched[3 + j];
        }
    }
    return free;
}

}  // namespace rockslip
