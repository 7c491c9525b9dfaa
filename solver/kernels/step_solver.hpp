// The solution of a step: the motions of all its bodies, with rows, friction and impulses that go with them.
#pragma once

#include "contact_search.hpp"
#include "free_motion.hpp"
#include "local_problem.hpp"

namespace rockslip {

template <int d> class StepSolver {
    using C = Contact<d>;

  public:
    StepSolver(World<d>& world, ContactSearch<d>& search, LocalProblem<d>& local) : world_(world), search_(search), local_(local) {}

    /// Solves all islands, with contacts that turn out later; marks bodies of those that have no
    /// solution. True where bodies went farther than anybody looked: margins are wider then.
    bool solve(Step<d>& step) {
        for (int round = 0; round < 8; round++) {
            gather_and_settle(step);
            bool strayed = false;
            for (int b : step.members) {
                if (step.failed[b]) continue;
                double turn = norm_from(step.w[b], d), go = 0;
                for (int i = 0; i < d; i++) go = std::hypot(go, step.w[b][i]);
                step.way[b] = 0.5 * step.piece.dt * (go + turn * world_.bodies[b].radius);
                if (!(step.way[b] > step.margin[b])) continue;
                strayed = true;
                step.least[b] = 2 * step.way[b];
            }
            if (!search_.find_late(step)) return strayed;
        }
        return false;
    }

    /// Solves the step of another length with the contacts that it has; false where that failed.
    bool solve_length(Step<d>& step, double length) {
        for (int b : step.members) {
            step.failed[b] = 0;
            step.w[b] = step.begun[b];
        }
        step.set_length(world_, length);
        gather_and_settle(step);
        return std::none_of(step.members.begin(), step.members.end(), [&](int b) { return step.failed[b]; });
    }

  private:
    static constexpr double FLOWN = 1e-12;  // of the motion of a body: changes below are none
    static constexpr double ROWS = 1e-14;   // of the size in a whole step: errors of rows below are none

    void gather_and_settle(Step<d>& step) {
        step.islands.gather(world_.bodies, step.members, {&step.contacts, &step.links}, [](const C&) { return true; });
        local_.tolerated_breach = 2e-10 * world_.size / step.piece.dt;
        for (Island<d>& island : step.islands) {
            if (!step.failed[island.bodies[0]] && settle(step, island)) continue;
            for (int b : island.bodies) {
                step.failed[b] = 1;
                step.end[b] = step.start[b].at;
            }
        }
        for (int b : step.members)
            if (!step.islands.holds(b) && !step.failed[b]) fly(step, b);
    }

    /// A body that touches nothing; one whose turn does not settle has failed.
    void fly(Step<d>& step, int b) const {
        const Body<d>& body = world_.bodies[b];
        const double dt = step.piece.dt;
        Motion<d>& w = step.w[b];
        if (body.is_platform()) w = step.free[b];
        else {
            double change = INFINITY, before = INFINITY;
            for (int round = 0; round < 40 && (change > FLOWN || change < before); round++) {
                step.end[b] = body.moved(0.5 * dt * w);  // forces turn with their arms
                const Motion<d> next = free_motion<d>(world_, step, b, {});
                before = change;
                change = norm(next - w) / std::max(norm(next), 1e-300);
                w = next;
                if ((d == 2 && world_.forces_on[b].empty()) || change <= 1e-15) {
                    change = 0;
                    break;
                }
            }
            if (!(change <= FLOWN)) step.failed[b] = 1;
        }
        step.end[b] = step.failed[b] ? step.start[b].at : body.moved(0.5 * dt * w);
    }

    /// Rows, friction and impulses of an island until none of them changes; false where they do not
    /// settle. Rows are right when their error moves no point by more than round-off of the size.
    bool settle(Step<d>& step, Island<d>& island) {
        const double dt = step.piece.dt;
        for (std::size_t j = 0; j < island.bodies.size(); j++) {
            island.mass[j] = step.mass[island.bodies[j]];
            island.inverse_mass[j] = step.inverse_mass[island.bodies[j]];
        }
        for (C* k : island.contacts) {
            if (k->link) k->impulse = -dt * k->link->link->force;  // a link begins with the force of the last step
            k->mode = FrictionMode::LAW;
            k->slips = false;
            k->anchor = k->impulse;
            k->bound = bound_at_start(*k->law, k->past, k->area * dt);
        }
        const double enough = ROWS * dt / world_.whole;
        const bool rough = step.piece.rough, begins_at_rest = at_rest(step, island);
        bool kept = false;  // impulses that nothing settled, while rows follow the motions
        for (int round = 0; round < 3 * FRICTION_ROUNDS; round++) {
            world_.counts.outer++;
            kept |= rough && round == FRICTION_ROUNDS;
            step.place_ends(world_, island.bodies);
            for (C* k : island.contacts) write_rows(step, *k);
            for (std::size_t j = 0; j < island.bodies.size(); j++) {
                const int b = island.bodies[j];
                const Motion<d> touched = round ? mul(step.mass[b], step.w[b] - island.free[j]) : Motion<d>{};
                island.free[j] = world_.bodies[b].is_platform() ? step.free[b] : free_motion(world_, step, b, touched);
            }
            if (kept) {
                if (!local_.keep(island)) return false;
            } else if (!local_.solve(island)) {
                if (builds_up_cohesion(island)) continue;
                if (!rough || !local_.approximate(island)) return false;
                kept = true;
            }
            if (round == 0)
                for (C* k : island.contacts) k->anchor = k->impulse;
            double off = take_motions(step, island);
            if (!(off < INFINITY)) return false;
            if (off > enough) continue;
            if (!kept && !local_.finish(island, begins_at_rest)) {
                if (!rough || !local_.take(island)) return false;
                kept = true;
                continue;
            }
            if (!kept && local_.is_loose() && !local_.take_back_gain(island)) return false;
            off = take_motions(step, island);
            bool again = off > 100 * enough;
            if (again)
                for (C* k : island.contacts) k->anchor = k->impulse;
            if (!kept)
                for (C* k : island.contacts) again |= follow(*k, island.least[1], dt, FRICTION_SHARES[round / FRICTION_ROUNDS]);
            if (again) continue;
            step.place_ends(world_, island.bodies);
            if (begins_at_rest && island.rests(1e-8 * dt * norm(world_.gravity), world_.size)) stay(step, island);
            return true;
        }
        return false;
    }

    /// Writes the rows of a contact or a link in the step, with the velocities 2/dt (gap, place) at its start.
    void write_rows(const Step<d>& step, C& k) const {
        const Vec<d> start = k.start;
        k.start = (2 / step.piece.dt) * start;
        step.write_rows(world_, k);
        k.start = start;
    }

    /// Takes the motions of an island; returns how far off the rows then are, of the size.
    double take_motions(Step<d>& step, const Island<d>& island) const {
        const double half = 0.5 * step.piece.dt;
        double changed = 0, turned = 0;
        const double shortest = shortest_link(island);  // turns where its ends move
        for (std::size_t j = 0; j < island.bodies.size(); j++) {
            Motion<d>& w = step.w[island.bodies[j]];
            for (int i = 0; i < Dim<d>::unknowns; i++) {
                const double next = island.w[j][i], change = half * std::fabs(next - w[i]);
                if (!std::isfinite(next)) return INFINITY;
                changed = std::max(changed, change * (i < d ? 1 : world_.size));
                turned = std::max(turned, half * std::fabs(next) / (i < d ? shortest : 1));
            }
            w = island.w[j];
        }
        return changed * turned / world_.size;
    }

    /// Length of the shortest axial link of an island at the start of the step, m; infinite without any.
    double shortest_link(const Island<d>& island) const {
        double found = INFINITY;
        for (const C* k : island.contacts)
            if (k->link && k->link->link->axial) found = std::min(found, k->link->link->length[0] + k->link->link->extension[0]);
        return std::max(found, 1e-6 * world_.size);
    }

    /// Lets cohesion grow with the pressure; false where it does so already.
    static bool builds_up_cohesion(const Island<d>& island) {
        bool changed = false;
        for (C* k : island.contacts)
            if (!k->link && k->bound.cohesion > 0 && std::isinf(k->bound.slope)) {
                k->bound.slope = COHESION_SLOPE;
                changed = true;
            }
        return changed;
    }

    /// True if all bodies of an island began without velocity.
    static bool at_rest(const Step<d>& step, const Island<d>& island) {
        return std::none_of(island.bodies.begin(), island.bodies.end(), [&](int b) { return norm(step.begun[b]) > 0; });
    }

    /// What stands on fixed ground, began at rest and goes less than the tolerance leaves stays where it is.
    static void stay(Step<d>& step, const Island<d>& island) {
        for (int b : island.bodies) {
            step.w[b].fill(0);
            step.end[b] = step.start[b].at;
        }
        for (C* k : island.contacts) k->y = k->constant;
    }

    /// Friction by the slip that it led to; true where it changed.
    bool follow(C& k, double compliance, double dt, double share) const {
        if (k.link || k.state == OPEN) return false;
        const double way = norm_from(k.y, 1);
        double force = 0;
        for (double each : k.impulse) force = std::max(force, std::fabs(each));
        k.slips = k.state != STICK && way > SLIP_ROUND_OFF * compliance * force && way > 1e-9 * dt * norm(world_.gravity);
        return follow_slip(*k.law, k.bound, k.slips ? 0.5 * way : 0.0, k.slips, share);
    }

    World<d>& world_;
    ContactSearch<d>& search_;
    LocalProblem<d>& local_;
};

}  // namespace rockslip
