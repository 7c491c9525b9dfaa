// Contact at velocity level after a step of rigid bodies: (M40) to (M42).
//
// Four problems are tried for the impulses, one after another: in 0 all contacts obey the law; in 1 those that slid
// stay at their bound, in the direction of their friction; in 2 they keep their friction; in 3 all do.
#pragma once

#include "instant.hpp"
#include "local_problem.hpp"

namespace rockslip {

template <int d> class VelocityCorrection {
    using C = Contact<d>;

  public:
    VelocityCorrection(World<d>& world, LocalProblem<d>& local) : world_(world), local_(local) {}

    /// Finds impulses such that no contact that is closed goes on closing, for all islands after a step.
    void correct(Step<d>& step) {
        step.islands.gather(world_.bodies, step.members, {&step.contacts}, [](const C& k) { return k.closed; });
        for (Island<d>& island : step.islands) correct(step, island);
    }

  private:
    /// What the step did at a contact, and the velocity it left there.
    struct Done {
        Vec<d> impulse, y, velocity;
        State state;

        /// Whether it slid with friction: where it did not press, round-off of its gap alone makes its state.
        bool slid() const { return impulse[0] > 0 && (state == SLIP || state == SLIP_BACK); }
    };

    /// Where a body landed all contacts obey the law first. A problem whose solution returns more energy than friction
    /// took in the step is left for the next; at last velocities stay as they are.
    void correct(const Step<d>& step, Island<d>& island) {
        const std::size_t count = island.contacts.size();
        done_.resize(count);
        double rubbed = 0, lost = 0, power = 0, quiet = 0;
        bool lands = false;
        start_instant(world_, step, island);
        for (std::size_t i = 0; i < count; i++) {
            const C& k = *island.contacts[i];
            done_[i] = {k.impulse, k.y, island.reading(k), k.state};
            rubbed += k.rubbed;
            lost += k.lost;
            power += std::fabs(dot(k.impulse, done_[i].velocity));
            lands |= k.gap > world_.touching() && k.state != OPEN;
            island.push(k, -1.0 * k.impulse, island.free);
        }
        const double dt = step.piece.dt;
        for (std::size_t j = 0; j < island.bodies.size(); j++) {
            island.free[j] = island.w[j] + mul(island.inverse_mass[j], island.free[j]);
            quiet += 1e-20 * world_.bodies[island.bodies[j]].mass * dt * dt * dot(world_.gravity, world_.gravity);
        }
        // What the step gained beside its friction may not be given back once more.
        const double taken = std::max(std::min(rubbed, lost), 0.0);
        int problem = lands ? 0 : 1;
        while (problem < 4 && !corrects(step, island, problem, taken, power, quiet)) problem++;
        world_.counts.rungs[problem]++;
        for (std::size_t i = 0; i < count; i++) {
            C& k = *island.contacts[i];
            if (problem < 4) k.velocity_impulse = k.total = k.impulse;
            k.impulse = done_[i].impulse;
            k.y = done_[i].y;
            k.state = done_[i].state;
        }
    }

    /// Solves a problem, and takes its velocities where energy allows it: not where it returns more than friction had
    /// `taken`, round-off of the `power` of the impulses and of what is `quiet` apart, J.
    bool corrects(const Step<d>& step, Island<d>& island, int problem, double taken, double power, double quiet) {
        for (std::size_t i = 0; i < island.contacts.size(); i++) pose(*island.contacts[i], done_[i], problem);
        if (!local_.solve(island) || !local_.finish(island)) return false;
        double lost = 0, normal = 0;
        for (std::size_t i = 0; i < island.contacts.size(); i++) {
            const C& k = *island.contacts[i];
            const Vec<d> y = island.reading(k);
            for (int j = 0; j < d; j++) {
                const double work = -0.5 * (k.impulse[j] - done_[i].impulse[j]) * (done_[i].velocity[j] + y[j]);
                lost += work;
                if (j == 0) normal += work;
            }
        }
        if (lost + taken < -1e-13 * power - quiet) return false;
        world_.ledger.book(lost, friction_share(lost - normal, lost, taken));
        if (island.rests(1e-8 * step.piece.dt * norm(world_.gravity), world_.size)) rest(island);
        take_velocities(world_, step, island);
        return true;
    }

    /// Sets what friction of a contact is in a problem, and where its impulse begins.
    static void pose(C& k, const Done& done, int problem) {
        k.mode = FrictionMode::LAW;
        k.impulse = k.was_closed && problem < 2 ? k.velocity_impulse : done.impulse;
        k.anchor = k.impulse;
        if (problem == 3 || (problem == 2 && done.slid())) {
            k.mode = FrictionMode::FIXED;
            k.given = done.impulse;
        } else if (problem == 1 && done.slid()) {
            const double size = norm_from(done.impulse, 1);
            k.mode = FrictionMode::AT_BOUND;
            k.given.fill(0);
            if (size > 0)
                for (int i = 1; i < d; i++) k.given[i] = done.impulse[i] / size;
        }
    }

    /// What stands on fixed ground does not drift by what the tolerance leaves: it rests.
    void rest(Island<d>& island) {
        for (std::size_t j = 0; j < island.bodies.size(); j++) {
            world_.ledger.contact += 0.5 * dot(island.w[j], mul(island.mass[j], island.w[j]));
            island.w[j].fill(0);
        }
    }

    World<d>& world_;
    LocalProblem<d>& local_;
    std::vector<Done> done_;
};

}  // namespace rockslip
