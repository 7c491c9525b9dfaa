// Pairs of bodies that have ever touched, and what they do to one another.
#pragma once

#include "contact.hpp"

namespace rockslip {

/// What two bodies that have ever touched do to one another, in the frame of their mean normal.
template <int d> struct TouchingPair {
    int a = 0, b = 0;        // a < b
    int points = 0;          // closed at the end of the step
    Vec<d> normal{};         // mean by the points, from b to a; as it was where nothing touches
    Vec<d> impulse{};        // of the step on a, N s
    double gap = 0;          // at the end of the step, along the axis that separates them best, m
    Vec<d> place{};          // where they press, mean by normal impulses, m; as it was where they do not
    double pressed = 0;      // normal impulses of the step, N s
    Vec<d> slip{};           // of a over b in contact, along the tangents of all steps, m; the first is unused

    /// First and, in space, second tangent: y x n and n x (y x n), clockwise from n in the plane.
    static std::array<Vec<d>, d - 1> tangents(const Vec<d>& n) {
        if constexpr (d == 2) return {Vec<2>{n[1], -n[0]}};
        else {
            const Vec<3> along = std::fabs(n[1]) < 0.9 ? Vec<3>{n[2], 0, -n[0]} : Vec<3>{n[1], -n[0], 0};
            const Vec<3> first = (1 / norm(along)) * along;
            return {first, cross(n, first)};
        }
    }

    void start_step() {
        points = 0;
        impulse.fill(0);
        pressed = 0;
    }

    /// Adds a contact that is closed, its impulses in space, N s, and its place, m.
    void add(const Contact<d>& k, const Vec<d>& force, const Vec<d>& at) {
        const double sign = k.feature.point_body == a ? 1 : -1;
        impulse += sign * force;
        const Vec<d> sum = points * normal + (sign / norm(k.axis(0))) * k.axis(0);
        const double length = norm(sum);
        if (length > 0) normal = (1 / length) * sum;
        points++;
        const double push = std::max(k.total[0], 0.0), share = pressed + push > 0 ? push / (pressed + push) : 0;
        place = (1 - share) * place + share * at;
        pressed += push;
    }
};

/// Pairs that have ever touched, in their order.
template <int d> struct TouchingPairs {
    bool wanted = false;  // whether they are told at all
    bool every = false;   // after every step of a run, not just the last one
    bool told = false;    // whether this step follows them
    std::vector<TouchingPair<d>> all;

    /// The pair of two bodies, made where it is not there.
    TouchingPair<d>& of(int one, int other) {
        const auto [low, high] = std::minmax(one, other);
        const auto before = [](const TouchingPair<d>& pair, const std::pair<int, int>& key) { return std::make_pair(pair.a, pair.b) < key; };
        auto at = std::lower_bound(all.begin(), all.end(), std::make_pair(low, high), before);
        if (at == all.end() || at->a != low || at->b != high) {
            at = all.insert(at, TouchingPair<d>{});
            at->a = low;
            at->b = high;
        }
        return *at;
    }
};

}  // namespace rockslip
