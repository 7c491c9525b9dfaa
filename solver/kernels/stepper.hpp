// Steps of a world.
//
// With w = v_n + v_{n+1} = 2 du/dt a step of generalized-alpha reads (M54) M (w - w_free) = G_m^T P and
// y = (2/dt) (gap, place)_{n+1} = c + G_m w with the rows of the middle of the step: the same problem as that of
// velocities, M (v - v_free) = G^T P with v_n complementary to P_n, so that one solver serves both. Impulses act at
// the end of the step, outside any average.
//
// Bodies near each other make groups. A group in which something touches hard, or stops to slide, is
// stepped to that instant and on from there; one whose contact is not solved, in halves.
#pragma once

#include <deque>

#include "event_instant.hpp"
#include "groups.hpp"
#include "impact.hpp"
#include "step_end.hpp"

namespace rockslip {

/// A world, and the steps that it takes.
template <int d> class Stepper {
  public:
    World<d> world;
    LocalProblem<d> local;

    /// One step; false where no step, however short, was solved.
    bool step(double dt, double smallest, const GroundMotion<d>& ground) {
        world.support.start_step();
        for (TouchingPair<d>& pair : world.pairs.all) pair.start_step();
        world.ground_impulse.fill(0);
        for (Link<d>& link : world.links) link.mean.fill(0);
        smallest_ = smallest;
        world.whole = dt;
        world.number++;
        const double begin = world.time;
        const bool solved = advance(0, world.moving, {begin, dt, ground, CUTS});
        if (solved) world.time = begin + dt;
        for (Link<d>& link : world.links)  // in the step in which it breaks it keeps the extension that it broke at
            if (link.broken && link.broken_at <= begin) link.extension = world.extension_of(link);
        if (world.number % 64 == 0) world.memory.forget_before(world.number - 2);
        if (world.pairs.told) measure_gaps(world);
        return solved;
    }

  private:
    static constexpr int CUTS = 5, MOST_WIDENED = 3;
    static constexpr int MOST_ROUGH = 16;      // parts of a step in which halves do not help
    static constexpr int LARGEST_CUT = 12;     // bodies of a group that is cut where nothing rebounds
    static constexpr int FEW_MOVING = 6;       // bodies that move in a larger one that is cut all the same
    static constexpr double FRACTURE = 1e-6;   // of the strength of a link, where events before change the instant

    /// Steps some bodies; where that needs it, in groups and in pieces.
    bool advance(int depth, const std::vector<int>& members, const Piece<d>& piece) {
        Step<d>& step = step_at(depth);
        step.begin(world, members, piece);
        for (int wider = 0;; wider++) {
            step.set_out(world);
            search_.find(step);
            if (!solver_.solve(step) || wider == MOST_WIDENED) break;
            world.counts.widened++;
        }
        const bool failed = std::any_of(members.begin(), members.end(), [&](int b) { return step.failed[b]; });
        if (!failed && !(piece.cuts > 0 && has_event(world, step))) return finish(step);
        const std::vector<std::vector<int>> groups = groups_of(world, step);
        if (groups.size() > 1) return by_groups(depth, groups);
        if (failed) return by_halves(depth, members, piece);
        if (is_cut(step)) return in_pieces(depth, members, piece);
        return finish(step);
    }

    Step<d>& step_at(int depth) {
        while (static_cast<int>(steps_.size()) <= depth) steps_.emplace_back();
        return steps_[depth];
    }

    bool finish(Step<d>& step) {
        finish_step(world, step, correction_);
        return true;
    }

    /// True if a group is stepped to the instant at which something happens. Where many bodies move, something
    /// happens in every step: there that is dear, and plastic impacts are of first order without.
    bool is_cut(const Step<d>& step) const {
        if (static_cast<int>(step.members.size()) <= LARGEST_CUT || moving_bodies(world, step) <= FEW_MOVING || has_fracture(world, step)) return true;
        return std::any_of(step.contacts.begin(), step.contacts.end(), [&](const Contact<d>& k) {
            return k.law->restitution > 0 && strikes(world, step, k, step.pull);
        });
    }

    /// Finishes the groups in which nothing happens, and steps the others one by one.
    bool by_groups(int depth, const std::vector<std::vector<int>>& groups) {
        Step<d>& step = step_at(depth);
        std::vector<int> group_of(world.bodies.size(), -1);
        std::vector<char> again(groups.size(), 0);
        for (std::size_t g = 0; g < groups.size(); g++)
            for (int b : groups[g]) {
                group_of[b] = static_cast<int>(g);
                again[g] |= step.failed[b];
            }
        const auto group = [&](const Contact<d>& k) {
            const int a = k.feature.point_body, b = k.feature.face_body;
            return group_of[world.bodies[a].moves() ? a : b];
        };
        const auto is_again = [&](const Contact<d>& k) { return again[group(k)] != 0; };
        for (std::vector<Contact<d>>* list : {&step.contacts, &step.links})
            for (const Contact<d>& k : *list)
                if (step.piece.cuts > 0 && has_event(world, step, k)) again[group(k)] = 1;
        for (std::vector<Contact<d>>* list : {&step.contacts, &step.links})
            list->erase(std::remove_if(list->begin(), list->end(), is_again), list->end());
        step.members.clear();
        for (std::size_t g = 0; g < groups.size(); g++)
            if (!again[g]) step.members.insert(step.members.end(), groups[g].begin(), groups[g].end());
        finish(step);
        for (std::size_t g = 0; g < groups.size(); g++)
            if (again[g] && !advance(depth + 1, groups[g], step.piece)) return false;
        return true;
    }

    /// Two steps of half the length; the shortest one is taken at the accuracy that there is, and what
    /// follows it in the step sooner than that.
    bool by_halves(int depth, const std::vector<int>& members, const Piece<d>& piece) {
        const double half = 0.5 * piece.dt;
        if (half >= smallest_ && (piece.halves || piece.dt > world.whole / MOST_ROUGH)) {
            world.counts.halved++;
            const long before = world.counts.unsettled;
            if (!advance(depth + 1, members, piece.first(half))) return false;
            Piece<d> rest = piece.rest(half);
            rest.halves = world.counts.unsettled == before;
            return advance(depth + 1, members, rest);
        }
        if (piece.rough) return false;
        world.counts.unsettled++;
        Piece<d> rough = piece.whole();
        rough.rough = true;
        return advance(depth + 1, members, rough);
    }

    /// Steps one group to the first touch or end of slip in it, and on from there.
    bool in_pieces(int depth, const std::vector<int>& members, const Piece<d>& piece) {
        Step<d>& step = step_at(depth);
        if (has_fracture(world, step)) return to_fracture(depth, members, piece);
        bool touches = false, at_start = false;
        for (const Contact<d>& k : step.contacts)
            if (strikes(world, step, k, step.pull)) {
                touches = true;
                at_start |= !is_new(world, k);
            }
        double length = 0.5 * AT_END * piece.dt;
        if (!touches) length = locate_end_of_slip(world, solver_, step);
        else if (!at_start) length = locate_touch(world, solver_, step);
        // Where no instant was found inside the step: all of it at once.
        if (!(length > 0)) return advance(depth + 1, members, piece.whole());
        world.counts.cut++;
        const bool at_once = length < AT_END * piece.dt;
        if (!at_once) finish(step);
        Piece<d> rest = at_once ? piece : piece.rest(length);
        rest.cuts--;
        // Without the jump the same contacts strike again at once: what is left of the step takes it.
        if (touches && !collide(depth + 1, members, rest.begin)) rest = rest.whole();
        return length == piece.dt || advance(depth + 1, members, rest);
    }

    /// Steps one group to the instant at which a link breaks, and on from there.
    bool to_fracture(int depth, const std::vector<int>& members, const Piece<d>& piece) {
        Step<d>& step = step_at(depth);
        std::vector<int> breaking;
        for (const Contact<d>& k : step.links)
            if (breaks(step, *k.link->link)) breaking.push_back(static_cast<int>(k.link->link - world.links.data()));
        const double length = locate_fracture(world, solver_, step, breaking);
        world.counts.cut++;
        if (length > AT_END * piece.dt) {
            Piece<d> before = piece.first(length);
            before.breaks = false;
            if (!advance(depth + 1, members, before)) return false;
        }
        for (int i : breaking) {
            Link<d>& link = world.links[i];
            if (link.load(link.extension) >= (1 - FRACTURE) * link.strength) world.ledger.damping += link.fracture(piece.begin + length);
        }
        Piece<d> rest = piece.rest(std::max(length, 0.0));
        rest.cuts--;
        return !(rest.dt > AT_END * piece.dt) || advance(depth + 1, members, rest);
    }

    /// Gives the velocities of some bodies a jump where contacts that touch come together; false where it is not found.
    bool collide(int depth, const std::vector<int>& members, double when) {
        Step<d>& step = step_at(depth);
        step.begin(world, members, {when, 0, {}, 0});
        step.set_out(world);
        search_.find(step);
        const bool found = impact_.collide(step);
        share_impulses(world, step);
        return found;
    }

    double smallest_ = 0;  // length of steps that are not divided, s
    std::deque<Step<d>> steps_;  // by their depth: of the step under way, of a piece of it, of a piece of that
    ContactSearch<d> search_{world};
    StepSolver<d> solver_{world, search_, local};
    VelocityCorrection<d> correction_{world, local};
    Impact<d> impact_{world, local};
};

}  // namespace rockslip
