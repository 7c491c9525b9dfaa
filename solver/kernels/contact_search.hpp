// The search for the contacts of a step: at its start, on the way, and where bodies ended.
#pragma once

#include "broad_phase.hpp"
#include "step.hpp"

namespace rockslip {

/// Adds the features of two bodies nearer than a margin to those found; returns how far they are apart along the axis
/// that separates best those of their parts which are nearest.
template <int d>
double find_features(const World<d>& world, int a, int b, const PlacedBody<d>& at_a, const PlacedBody<d>& at_b, double margin,
                     std::vector<Feature<d>>& found) {
    const auto are_apart = [&](const PlacedShape<d>& one, const PlacedShape<d>& other) {
        for (int k = 0; k < d; k++)
            if (one.low[k] > other.high[k] + margin || other.low[k] > one.high[k] + margin) return true;
        return false;
    };
    double least = INFINITY;
    for (std::size_t i = 0; i < at_a.parts.size(); i++)
        for (std::size_t j = 0; j < at_b.parts.size(); j++) {
            const PlacedShape<d>&one = at_a.parts[i], &other = at_b.parts[j];
            if (at_a.parts.size() + at_b.parts.size() > 2 && are_apart(one, other)) continue;
            const std::size_t before = found.size();
            NarrowPhase<d> narrow(a, b, world.part(a, i), world.part(b, j), one, other, margin, world.hair(), found);
            least = std::min(least, narrow.find());
            for (std::size_t f = before; f < found.size(); f++) {
                const bool first = found[f].point_body == a;
                found[f].point_part = static_cast<int>(first ? i : j);
                found[f].face_part = static_cast<int>(first ? j : i);
            }
        }
    return least;
}

/// Writes the gaps of the pairs that have ever touched.
template <int d> void measure_gaps(World<d>& world) {
    std::vector<Feature<d>> none;
    for (TouchingPair<d>& pair : world.pairs.all) {
        PlacedBody<d> here, there;
        here.place(world.shapes, world.bodies[pair.a].parts, world.bodies[pair.a].placement());
        there.place(world.shapes, world.bodies[pair.b].parts, world.bodies[pair.b].placement());
        none.clear();
        // No margin cuts the search short: the axis has to be the best of all.
        pair.gap = find_features(world, pair.a, pair.b, here, there, INFINITY, none);
    }
}

template <int d> class ContactSearch {
  public:
    explicit ContactSearch(World<d>& world) : world_(world) {}

    /// Finds the contacts of a step, by the places at its start and by those where bodies go by their velocities.
    void find(Step<d>& step) {
        step.pairs = broad_.find(step.listed, world_.bodies, step.start, step.margin);
        step.apart.resize(step.pairs.size());
        step.contacts.clear();
        step.first.clear();
        if (!step.all_still) look_ahead(step);
        for (std::size_t i = 0; i < step.pairs.size(); i++) {
            const auto [a, b] = step.pairs[i];
            const double margin = step.margin[a] + step.margin[b];
            step.first.push_back(step.contacts.size());
            step.apart[i] = look(a, b, step.start, margin);
            if (-step.apart[i] > world_.deepest.depth) world_.deepest = {-step.apart[i], world_.time, a, b};
            for (const Feature<d>& feature : found_) add(step, feature);
            if (step.still[a] && step.still[b]) continue;
            look(a, b, step.other, margin);
            for (const Feature<d>& feature : found_) add_late(step, i, feature);
        }
        step.first.push_back(step.contacts.size());
    }

    /// Adds contacts that overlap at the end of the step though they were none; true where there are any.
    bool find_late(Step<d>& step) {
        if (step.all_still) return false;
        for (int b : step.members) step.other[b].place(world_.shapes, world_.bodies[b].parts, step.end[b]);
        for (int b : world_.fixed) step.other[b] = step.start[b];
        bool more = false;
        for (std::size_t i = 0; i < step.pairs.size(); i++) {
            const auto [a, b] = step.pairs[i];
            if ((step.still[a] && step.still[b]) || step.failed[a] || step.failed[b]) continue;
            const double apart = look(a, b, step.other, 0);
            bool added = false;
            if (apart < -1e-10 * world_.size)
                for (const Feature<d>& feature : found_)
                    if (step.end_gap(world_, feature) < -1e-11 * world_.size && add_late(step, i, feature)) {
                        world_.counts.late++;
                        added = more = true;
                    }
            // Nobody can say where they met: a shorter step knows.
            if (!added && !step.piece.rough && apart < std::min(step.apart[i], 0.0) - world_.touching())
                for (int body : {a, b})
                    if (world_.bodies[body].moves()) step.failed[body] = 1;
        }
        return more;
    }

  private:
    /// Places bodies where their velocities and the load take them.
    void look_ahead(Step<d>& step) const {
        const double dt = step.piece.dt;
        for (int b : world_.fixed) step.other[b] = step.start[b];
        for (int b : step.members) {
            const Body<d>& body = world_.bodies[b];
            Motion<d> increment = 0.5 * dt * step.w[b];
            if (!body.is_platform())
                for (int i = 0; i < d; i++) increment[i] += 0.5 * dt * dt * step.load[i];
            step.other[b].place(world_.shapes, body.parts, body.moved(increment));
        }
    }

    /// Finds the features of a pair at some places; returns how far it is apart.
    double look(int a, int b, const std::vector<PlacedBody<d>>& placed, double margin) {
        found_.clear();
        return find_features(world_, a, b, placed[a], placed[b], margin, found_);
    }

    /// Adds a contact of a pair unless it is there, or was below its face, beside it, at the start; true
    /// where it is added.
    bool add_late(Step<d>& step, std::size_t pair, const Feature<d>& feature) {
        std::vector<Contact<d>>& contacts = step.contacts;
        const int low = step.pairs[pair].first, high = step.pairs[pair].second;
        const std::uint64_t id = feature.id();
        const auto is_there = [&](std::size_t from, std::size_t to) {
            return std::any_of(contacts.begin() + from, contacts.begin() + to, [&](const Contact<d>& k) {
                return k.id == id && std::minmax(k.feature.point_body, k.feature.face_body) == std::minmax(low, high);
            });
        };
        const std::size_t count = contacts.size(), end = pair + 1 < step.first.size() ? step.first[pair + 1] : count;
        if (is_there(step.first[pair], end) || is_there(std::max(end, step.first.back()), count)) return false;
        add(step, feature);
        const bool below = contacts.back().gap < -world_.touching() && !contacts.back().was_closed;
        if (below) contacts.pop_back();
        return !below;
    }

    void add(Step<d>& step, const Feature<d>& feature) {
        const int a = feature.point_body, b = feature.face_body;
        const auto [low, high] = std::minmax(a, b);
        step.contacts.emplace_back();
        Contact<d>& k = step.contacts.back();
        k.feature = feature;
        k.id = feature.id();
        k.free_point = world_.bodies[a].is_free();
        k.law = &world_.law(low, high);
        k.gap = world_.gap(feature, step.start[a].at, step.start[b].at);
        if (const Remembered<d>* before = world_.memory.find(low, high, k.id)) {
            k.past = before->friction;
            if (before->step >= world_.number - 1) {
                k.impulse = before->impulse;
                k.velocity_impulse = before->velocity_impulse;
                k.was_closed = before->closed;
                if (before->closed && std::fabs(k.gap - before->gap) < world_.round_off()) k.gap = before->gap;
                if (before->closed)
                    for (int i = 1; i < d; i++) k.start[i] = before->offset[i];
            }
        }
        // Contacts that say the same must not differ by round-off of places.
        if (std::fabs(k.gap) < world_.round_off()) k.gap = 0;
        k.start[0] = std::max(k.gap, 0.0);  // what has sunk in is held: pushed out it would gain energy
        k.area = feature.area;
        if constexpr (d == 2) k.area *= std::min(thickness(a), thickness(b));
    }

    double thickness(int b) const { return world_.bodies[b].is_free() ? world_.bodies[b].thickness : INFINITY; }

    World<d>& world_;
    BroadPhase<d> broad_;
    std::vector<Feature<d>> found_;
};

}  // namespace rockslip
