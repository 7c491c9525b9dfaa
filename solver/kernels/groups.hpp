// Groups: bodies near each other, which step together.
#pragma once

#include "broad_phase.hpp"
#include "step.hpp"

namespace rockslip {

/// The members of a step in groups of those near each other, however fast they left.
template <int d> std::vector<std::vector<int>> groups_of(const World<d>& world, const Step<d>& step) {
    const std::vector<Body<d>>& bodies = world.bodies;
    DisjointSets sets;
    sets.part(step.members, bodies.size());
    const auto join = [&](int a, int b) {
        if (bodies[a].moves() && bodies[b].moves()) sets.join(a, b);
    };
    for (const auto* list : {&step.contacts, &step.links})
        for (const Contact<d>& k : *list) join(k.feature.point_body, k.feature.face_body);
    std::vector<double> margin = step.margin;
    for (int b : step.members) margin[b] = 2 * std::max(step.margin[b], step.way[b]);
    BroadPhase<d> broad;
    for (const auto& [a, b] : broad.find(step.listed, bodies, step.start, margin)) join(a, b);
    std::vector<std::vector<int>> groups;
    std::vector<int> number(bodies.size(), -1);
    for (int b : step.members) {
        int& at = number[sets.top(b)];
        if (at < 0) {
            at = static_cast<int>(groups.size());
            groups.emplace_back();
        }
        groups[at].push_back(b);
    }
    return groups;
}

}  // namespace rockslip
