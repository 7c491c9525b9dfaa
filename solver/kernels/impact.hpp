// Impacts: jumps of the velocities where contacts that touch come together.
//
// The law of impact on the touching contacts of an island, at an instant:
//
//     0 <= P_n  complementary to  v_n+ - r >= 0,     r = e [-v_n-(2 c - x)]_+,            (M48)
//
// x being the place of the contact and c the middle of the two contacts of its pair that are
// farthest apart: a contact takes the rebound of the place opposite. A block that stands on one
// edge and lands on the opposite one leaves the first with e times the speed of the landing, as in
// Housner's equation; one that lands flat rebounds with e times its speed, as in Newton's law. What
// lands alone has no rebound, nor has in space an edge. Below Housner's e the old pivots have to
// be held back: there alone an impulse may pull.
#pragma once

#include "instant.hpp"
#include "local_problem.hpp"

namespace rockslip {

template <int d> class Impact {
    using C = Contact<d>;
    using Motions = std::vector<Motion<d>>;

  public:
    Impact(World<d>& world, LocalProblem<d>& local) : world_(world), local_(local) {}

    /// Gives the velocities a jump where contacts of a step without length come together, and books it; false where
    /// there is an island whose jump is not found.
    bool collide(Step<d>& step) {
        for (C& k : step.contacts) {
            k.closed = k.gap <= LANDING * world_.size;
            k.end_gap = k.gap;
        }
        step.islands.gather(world_.bodies, step.members, {&step.contacts}, [](const C& k) { return k.closed; });
        bool found = true;
        for (Island<d>& island : step.islands) found &= strike(step, island);
        for (const C& k : step.contacts)
            if (k.closed && k.impulse[0] > 0) remember(k);
        return found;
    }

  private:
    static constexpr double LANDING = 1e-8;  // of the size: contacts closer than this land together
    static constexpr double PIVOT = 1e-6;    // of the speed of a landing: slower contacts are its pivots

    /// Notes that a contact struck, and how fast it slips afterwards.
    void remember(const C& k) {
        const auto [low, high] = std::minmax(k.feature.point_body, k.feature.face_body);
        Remembered<d>& record = world_.memory.record(low, high, k.id);
        const double rate = k.state == SLIP || k.state == SLIP_BACK ? norm_from(k.y, 1) : 0.0;
        const bool broken = record.friction.broken || rate > 0;
        record = {k.id, {}, {}, {}, k.gap, true, {rate, rate > 0, broken}, world_.number};
    }

    /// The impact of an island; false where it is not found.
    bool strike(const Step<d>& step, Island<d>& island) {
        start_instant(world_, step, island);
        velocity_ = island.w;
        island.free = island.w;
        const std::size_t count = island.contacts.size();
        before_.resize(count);
        bool approaching = false, rebounding = false;
        for (std::size_t i = 0; i < count; i++) {
            C& k = *island.contacts[i];
            before_[i] = island.reading(k);
            approaching |= before_[i][0] < 0;
            rebounding |= k.law->restitution > 0;
            k.mode = FrictionMode::LAW;
            k.bound = bound_at_start(*k.law, k.past, 0);
        }
        if (!approaching) return true;
        if (!settle(island)) return false;
        if (rebounding) rebound(step, island);
        island.move();
        double lost = 0, normal = 0;
        for (std::size_t i = 0; i < count; i++) {
            C& k = *island.contacts[i];
            k.constant.fill(0);
            const Vec<d> sum = before_[i] + island.reading(k);
            lost -= 0.5 * dot(k.impulse, sum);
            normal -= 0.5 * k.impulse[0] * sum[0];
            k.total = k.impulse;
        }
        world_.ledger.book(lost, friction_share(lost - normal, lost, 0));
        take_velocities(world_, step, island);
        record_collisions(step, island);
        return true;
    }

    /// Impulses of an impact from none, with the friction of the slip that they leave.
    bool settle(Island<d>& island) {
        for (C* k : island.contacts) {
            k->impulse.fill(0);
            k->anchor.fill(0);
        }
        for (double share : FRICTION_SHARES)
            for (int round = 0; round < FRICTION_ROUNDS; round++) {
                if (!local_.solve(island)) return false;
                bool changed = false;
                for (std::size_t i = 0; i < island.contacts.size(); i++) {
                    C& k = *island.contacts[i];
                    const bool slips = k.state == SLIP || k.state == SLIP_BACK;
                    const double speed = 0.5 * norm_from(before_[i] + island.reading(k), 1);
                    if (k.mode == FrictionMode::LAW && k.bound.mu > 0) changed |= follow_slip(*k.law, k.bound, slips ? speed : 0.0, slips, share);
                }
                if (!changed) return local_.finish(island);
            }
        return false;
    }

    /// Replaces the impulses of a plastic impact by those with rebounds, as far as these gain no energy.
    void rebound(const Step<d>& step, Island<d>& island) {
        const std::size_t count = island.contacts.size();
        const auto impulses = [&] {
            std::vector<Vec<d>> all(count);
            for (std::size_t i = 0; i < count; i++) all[i] = island.contacts[i]->impulse;
            return all;
        };
        const std::vector<Vec<d>> plastic = impulses();
        std::vector<double> speed(count, 0), pull(count, 0);
        std::vector<char> pivot(count, 0);
        if (!find_rebounds(step, island, speed, pivot)) return;
        for (std::size_t i = 0; i < count; i++) island.contacts[i]->constant[0] = -speed[i];
        if (!settle(island)) {
            for (std::size_t i = 0; i < count; i++) island.contacts[i]->impulse = plastic[i];
            return;
        }
        double pressed = 0;
        bool pulls = false;
        for (const Vec<d>& P : plastic) pressed += P[0];
        for (std::size_t i = 0; i < count; i++) {
            C& k = *island.contacts[i];
            if (!pivot[i] || !(k.y[0] > PIVOT * std::max(speed[i], 1e-300))) continue;
            pull[i] = pressed;
            k.bound.mu = 0;
            pulls = true;
        }
        std::vector<Vec<d>> found = impulses();
        for (int round = 0; pulls && round < 8; round++) {
            if (settles_held(island, pull)) {
                found = impulses();
                for (std::size_t i = 0; i < count; i++) found[i][0] -= pull[i];
                break;
            }
            for (double& each : pull) each *= 10;
        }
        island.free = velocity_;
        take_without_gain(island, plastic, found);
    }

    /// Impulses while normal ones pull contacts together besides; false where some of these hold a contact no more.
    bool settles_held(Island<d>& island, const std::vector<double>& pull) {
        island.free = velocity_;
        for (std::size_t i = 0; i < pull.size(); i++) {
            Vec<d> held{};
            held[0] = -pull[i];
            pushed_.assign(island.w.size(), {});
            island.push(*island.contacts[i], held, pushed_);
            for (std::size_t j = 0; j < island.w.size(); j++) island.free[j] += mul(island.inverse_mass[j], pushed_[j]);
        }
        if (!settle(island)) return false;
        for (std::size_t i = 0; i < pull.size(); i++)
            if (pull[i] != 0 && !(island.contacts[i]->impulse[0] > 0.5 * pull[i])) return false;
        return true;
    }

    /// Impulses on the way from those of the plastic impact as far as no energy is gained: what is lost
    /// on the way is a parabola.
    void take_without_gain(Island<d>& island, const std::vector<Vec<d>>& plastic, const std::vector<Vec<d>>& found) {
        const std::size_t count = island.contacts.size();
        const auto motion_of = [&](auto impulse) {
            Motions moved(island.w.size(), Motion<d>{});
            for (std::size_t i = 0; i < count; i++) island.push(*island.contacts[i], impulse(i), moved);
            for (std::size_t j = 0; j < moved.size(); j++) moved[j] = mul(island.inverse_mass[j], moved[j]);
            return moved;
        };
        const auto first = motion_of([&](std::size_t i) { return plastic[i]; });
        const auto way = motion_of([&](std::size_t i) { return found[i] - plastic[i]; });
        double lost = 0, slope = 0, curve = 0, power = 0;
        for (std::size_t j = 0; j < way.size(); j++) {
            const Motion<d> pushed = mul(island.mass[j], first[j]), along = mul(island.mass[j], way[j]);
            lost -= dot(pushed, velocity_[j]) + 0.5 * dot(pushed, first[j]);
            slope -= dot(along, velocity_[j]) + dot(along, first[j]);
            curve += 0.5 * dot(along, way[j]);
        }
        for (std::size_t i = 0; i < count; i++) power += std::fabs(dot(found[i], before_[i]));
        double part = 1;
        if (lost + slope - curve < -1e-14 * power) part = std::clamp((slope + std::sqrt(slope * slope + 4 * curve * std::max(lost, 0.0))) / (2 * curve), 0.0, 1.0);
        for (std::size_t i = 0; i < count; i++) island.contacts[i]->impulse = plastic[i] + part * (found[i] - plastic[i]);
    }

    /// The rebound of each contact, and which of them are pivots of a block that lands; false where
    /// there is no rebound.
    bool find_rebounds(const Step<d>& step, const Island<d>& island, std::vector<double>& speed, std::vector<char>& pivot) const {
        const std::size_t count = island.contacts.size();
        std::vector<Vec<d>> place(count);
        for (std::size_t i = 0; i < count; i++) place[i] = step.place(world_, *island.contacts[i]);
        const auto same_pair = [&](std::size_t i, std::size_t j) {
            const Feature<d>&x = island.contacts[i]->feature, &y = island.contacts[j]->feature;
            return std::minmax(x.point_body, x.face_body) == std::minmax(y.point_body, y.face_body);
        };
        bool any = false;
        for (std::size_t i = 0; i < count; i++) {
            const C& k = *island.contacts[i];
            std::size_t a = count, b = count;
            double farthest = 0;
            for (std::size_t j = 0; j < count; j++)
                for (std::size_t l = 0; l < j; l++)
                    if (same_pair(i, j) && same_pair(i, l) && norm(place[j] - place[l]) > farthest) {
                        a = j;
                        b = l;
                        farthest = norm(place[j] - place[l]);
                    }
            if (a == count) continue;
            const double opposite = before_[i][0] + dot(gradient(k), place[a] + place[b] - 2.0 * place[i]);
            double together = 0;
            if (d == 3) {
                bool on_a_line = true;
                const Vec<d> line = place[b] - place[a];
                for (std::size_t j = 0; j < count; j++) {
                    if (!same_pair(i, j)) continue;
                    const Vec<d> aside = place[j] - place[a];
                    on_a_line &= norm(aside - (dot(aside, line) / dot(line, line)) * line) <= PIVOT * norm(line);
                }
                if (on_a_line) together = std::max(std::min(-before_[a][0], -before_[b][0]), 0.0);
            }
            speed[i] = k.law->restitution * std::max(-opposite - together, 0.0);
            pivot[i] = opposite < 0 && std::fabs(before_[i][0]) < PIVOT * std::fabs(opposite);
            any |= speed[i] > 0;
        }
        return any;
    }

    /// Spin of the body of a contact's point against that of its face, in space.
    static Turn<d> relative_spin(const C& k, const Motions& motions) {
        Turn<d> spin;
        for (int i = 0; i < Dim<d>::rotations; i++) spin[i] = (k.a >= 0 ? motions[k.a][d + i] : 0) - (k.b >= 0 ? motions[k.b][d + i] : 0);
        return spin;
    }

    /// Gradient of the normal velocity of a contact over its place, 1/s: n x omega of the relative spin.
    Vec<d> gradient(const C& k) const {
        const Turn<d> spin = relative_spin(k, velocity_);
        const Vec<d> n = k.axis(0);
        if constexpr (d == 2) return {spin[0] * n[1], -spin[0] * n[0]};
        else return cross(n, spin);
    }

    /// Notes the bodies that met, by the impulses and velocities of their points.
    void record_collisions(const Step<d>& step, const Island<d>& island) {
        InstantCollisions<d> met(step.piece.begin);
        for (std::size_t i = 0; i < island.contacts.size(); i++) {
            const C& k = *island.contacts[i];
            if (k.was_closed || !(k.impulse[0] > 0) || !(before_[i][0] < 0)) continue;
            const double own = k.a >= 0 ? -dot(k.rows_a[0], velocity_[k.a]) : 0;
            met.add({k, step.place(world_, k), before_[i], island.reading(k), own, relative_spin(k, velocity_), relative_spin(k, island.w)});
        }
        // What the impact does where the two touched before belongs to it.
        for (std::size_t i = 0; i < island.contacts.size(); i++) {
            const C& k = *island.contacts[i];
            if (k.was_closed) met.add_impulse(k, before_[i] + island.reading(k));
        }
        met.append_to(world_.collisions);
    }

    World<d>& world_;
    LocalProblem<d>& local_;
    std::vector<Vec<d>> before_;
    Motions velocity_, pushed_;
};

}  // namespace rockslip
