// Slip of bodies over what carries them, and of pairs of bodies, through a step.
#pragma once

#include <map>
#include <tuple>

#include "step.hpp"

namespace rockslip {

/// Way of the lowest corner of a body over its carrier, in the carrier's frame.
template <int d> Vec<d> way_in_flight(const World<d>& world, const Step<d>& step, int b, int carrier) {
    const auto local_place = [&](const Placement<d>& own, const Placement<d>& base, const Vec<d>& corner) {
        return transposed_mul(base.R, (own.centre - base.centre) + mul(own.R, corner));
    };
    double lowest = INFINITY;
    Vec<d> way{};
    for (int number : world.bodies[b].parts)
        for (const Vec<d>& corner : world.shapes[number].vertices) {
            const Vec<d> after = local_place(step.end[b], step.end[carrier], corner);
            if (after[d - 1] >= lowest) continue;
            lowest = after[d - 1];
            way = after - local_place(step.start[b].at, step.start[carrier].at, corner);
        }
    return way;
}

/// Adds to the slip of each body the mean way of the contacts with what carries it, along the axes of the first body
/// that does, or the way of its lowest corner.
template <int d> void follow_slips(World<d>& world, const Step<d>& step) {
    Support<d>& support = world.support;
    for (int b : step.members) support.ways[b] = {};
    for (const Contact<d>& k : step.contacts) {
        if (k.state == OPEN) continue;
        const int point = k.feature.point_body, face = k.feature.face_body;
        const bool upper_has_point = support.carries(face, point);
        if (!upper_has_point && !support.carries(point, face)) continue;
        const int b = upper_has_point ? point : face, carrier = support.carriers[b][0];
        Vec<d> slipped{};
        step.add_slip(k, upper_has_point ? 1 : -1, slipped);
        support.ways[b].add(transposed_mul(mean(step.start[carrier].at.R, step.end[carrier].R), slipped));
    }
    for (int b : step.members) {
        if (support.carriers[b].empty()) continue;
        const MeanWay<d>& way = support.ways[b];
        support.slip[b] += way.contacts ? way.mean() : way_in_flight(world, step, b, support.carriers[b][0]);
    }
}

/// Adds to the slip of each pair the mean way of its contacts.
template <int d> void follow_pairs(TouchingPairs<d>& pairs, const Step<d>& step) {
    std::map<std::pair<int, int>, std::tuple<Vec<d>, Vec<d>, int>> ways;
    for (const Contact<d>& k : step.contacts) {
        if (k.state == OPEN) continue;
        const int a = k.feature.point_body, b = k.feature.face_body;
        const double sign = a < b ? 1 : -1;
        auto& [way, normal, count] = ways[std::minmax(a, b)];
        step.add_slip(k, sign, way);
        normal += sign * k.axis(0);
        count++;
    }
    for (const auto& [key, found] : ways) {
        const auto& [way, normal, count] = found;
        TouchingPair<d>& pair = pairs.of(key.first, key.second);
        if (!(norm(normal) > 0)) continue;
        const auto along = pair.tangents((1 / norm(normal)) * normal);
        for (int i = 1; i < d; i++) pair.slip[i] += dot(way, along[i - 1]) / count;
    }
}

}  // namespace rockslip
