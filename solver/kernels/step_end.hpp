// The end of a step that is solved: places, velocities, memory, and what it tells.
#pragma once

#include "event.hpp"
#include "slip.hpp"
#include "velocity_correction.hpp"

namespace rockslip {

/// Notes the contacts that closed in a step which was not cut there.
template <int d> void record_landings(World<d>& world, const Step<d>& step) {
    InstantCollisions<d> met(step.piece.begin + step.piece.dt);
    for (const Contact<d>& k : step.contacts) {
        if (!strikes(world, step, k, norm(world.gravity))) continue;
        const int a = k.feature.point_body, b = k.feature.face_body;
        Vec<d> before{};
        before[0] = -approach(step, k);
        const double own = -0.5 * dot(k.rows_a[0], step.begun[a]);
        Turn<d> spin, later;
        later.fill(NAN);  // not before the velocity level
        for (int i = 0; i < Dim<d>::rotations; i++) spin[i] = 0.5 * (step.begun[a][d + i] - step.begun[b][d + i]);
        met.add({k, step.place(world, k), before, {}, own, spin, later});
    }
    met.append_to(world.collisions);
}

/// Books a contact, and notes whether it is closed and slides.
template <int d> void close_contact(World<d>& world, const Step<d>& step, Contact<d>& k) {
    const double half = 0.5 * step.piece.dt;
    k.rubbed = 0;
    for (int i = 1; i < d; i++) k.rubbed -= 0.5 * k.impulse[i] * k.y[i];
    k.lost = -0.5 * dot(k.impulse, step.moved(k, step.w));
    world.ledger.book(k.lost, k.rubbed);
    k.closed = k.state != OPEN || half * k.y[0] < 1e-11 * world.size;
    if (k.state != OPEN && k.state != STICK && !k.slips) k.state = STICK;
    k.total = k.impulse;
    k.end_gap = k.gap - k.start[0] + (k.state == OPEN ? half * k.y[0] : 0.0);
}

/// Books a link; one that is stronger loaded than where it breaks, at an instant that was not found, breaks.
template <int d> void close_link(World<d>& world, const Step<d>& step, const Contact<d>& k) {
    const double dt = step.piece.dt;
    Link<d>& link = world.links[k.link->link - world.links.data()];
    const Vec<d> reached = link.measure(step.end[link.a], step.end[link.b]);
    double work = 0;  // on the bodies
    for (int i = 0; i < link.directions(); i++) {
        work += k.impulse[i] / dt * (reached[i] - link.extension[i]);
        link.force[i] = -k.impulse[i] / dt;
        link.mean[i] -= k.impulse[i] / world.whole;
    }
    world.ledger.damping += link.take(reached, work);
    if (step.piece.breaks && link.load(link.extension) > (1 + BREAKING) * link.strength)
        world.ledger.damping += link.fracture(step.piece.begin + dt);
}

/// Moves a body to the end of the step, and books the work of what acts on it.
template <int d> void move_body(World<d>& world, const Step<d>& step, int b) {
    Body<d>& body = world.bodies[b];
    const double dt = step.piece.dt;
    const Motion<d>& w = step.w[b];
    const Mat<d, d>& R = step.start[b].at.R;
    Vec<d> du;
    Turn<d> turn;
    for (int i = 0; i < d; i++) du[i] = 0.5 * dt * w[i];
    for (int i = 0; i < Dim<d>::rotations; i++) turn[i] = w[d + i];
    for (int i : world.forces_on[b]) {
        const AppliedForce<d>& force = world.forces[i];
        const Vec<d> way = du + (mul(step.end[b].R, force.arm) - mul(R, force.arm));
        world.ledger.input += dot(step.mean_force(world, force), way);
    }
    if (body.is_platform()) du[d - 1] = 0;
    world.ledger.input -= body.mass * dot(step.piece.ground.mean(dt), du);
    if (body.is_platform()) take_platform(body, world.scheme, du, dt, world.ledger, world.ground_impulse);
    body.x += du;
    for (int i = 0; i < d; i++) body.v[i] = (body.is_platform() && i == d - 1) ? 0 : w[i] - body.v[i];
    if (body.is_platform()) return;
    body.rotation = body.rotation.turned(0.5 * dt * turn);
    body.turned = rotation_vector(body.rotation, body.turned);
    body.spin = to_body(R, turn) - body.spin;
}

/// Writes what the next step is to know of a contact.
template <int d> void remember(World<d>& world, const Step<d>& step, const Contact<d>& k) {
    const auto [low, high] = std::minmax(k.feature.point_body, k.feature.face_body);
    Remembered<d>& record = world.memory.record(low, high, k.id);
    record.impulse = k.impulse;
    record.velocity_impulse = k.velocity_impulse;
    record.closed = k.closed;
    record.gap = k.end_gap;
    record.offset.fill(0);
    record.step = world.number;
    if (k.state == STICK && k.feature.kind != Kind::EDGE_EDGE && !step.piece.rough)
        for (int i = 1; i < d; i++) record.offset[i] = 0.5 * step.piece.dt * k.y[i];
    record.friction = k.past;
    record.friction.rate = record.friction.slipped = false;
    if (k.closed && k.state != OPEN && k.slips) {
        record.friction.rate = 0.5 * norm_from(k.y, 1);
        record.friction.slipped = record.friction.broken = true;
    }
}

/// Adds the impulses of the contacts that are closed to what their bodies got in this step.
template <int d> void share_impulses(World<d>& world, const Step<d>& step) {
    for (const Contact<d>& k : step.contacts) {
        if (!k.closed) continue;
        Vec<d> force{};
        for (int i = 0; i < d; i++) force += k.total[i] * k.axis(i);
        if (world.pairs.told) world.pairs.of(k.feature.point_body, k.feature.face_body).add(k, force, step.place(world, k));
        world.support.add(k, force);
    }
}

/// Takes a solved step; then contact at velocity level.
template <int d> void finish_step(World<d>& world, Step<d>& step, VelocityCorrection<d>& correction) {
    const long count = static_cast<long>(step.contacts.size());
    world.counts.contacts += count;
    world.counts.most_contacts = std::max(world.counts.most_contacts, count);
    follow_slips(world, step);
    if (world.pairs.told) follow_pairs(world.pairs, step);
    record_landings(world, step);
    for (Contact<d>& k : step.contacts) close_contact(world, step, k);
    for (const Contact<d>& k : step.links) close_link(world, step, k);
    for (int b : step.members) move_body(world, step, b);
    for (int b : step.members) step.start[b].at = world.bodies[b].placement();
    if (world.velocity_level) correction.correct(step);
    for (const Contact<d>& k : step.contacts) remember(world, step, k);
    share_impulses(world, step);
}

}  // namespace rockslip
