// An island at an instant: its rows, masses and velocities there.
#pragma once

#include "step.hpp"

namespace rockslip {

/// Writes rows, masses and velocities of an island as it is at the start of a step, without impulses.
template <int d> void start_instant(const World<d>& world, const Step<d>& step, Island<d>& island) {
    for (std::size_t j = 0; j < island.bodies.size(); j++) {
        const int b = island.bodies[j];
        const Mat<d, d>& R = step.start[b].at.R;
        world.bodies[b].write_mass(R, island.mass[j], island.inverse_mass[j]);
        island.w[j] = world.bodies[b].velocities(R);
        island.free[j].fill(0);
    }
    for (Contact<d>* k : island.contacts) {
        k->start.fill(0);
        step.write_rows_at_start(world, *k);
    }
}

/// Gives the bodies of an island its velocities.
template <int d> void take_velocities(World<d>& world, const Step<d>& step, const Island<d>& island) {
    for (std::size_t j = 0; j < island.bodies.size(); j++) {
        Body<d>& body = world.bodies[island.bodies[j]];
        Turn<d> turning;
        for (int i = 0; i < d; i++) body.v[i] = island.w[j][i];
        for (int i = 0; i < Dim<d>::rotations; i++) turning[i] = island.w[j][d + i];
        if (!body.is_platform()) body.spin = to_body(step.start[island.bodies[j]].at.R, turning);
    }
}

}  // namespace rockslip
