// A step of some bodies: where they begin, their contacts, and how they move.
#pragma once

#include "island.hpp"
#include "world.hpp"

namespace rockslip {

/// A step or a piece of one: when it begins (s), its length (s), and the motion of the ground.
template <int d> struct Piece {
    double begin, dt;
    GroundMotion<d> ground;
    int cuts;             // how often it may be cut at an event
    bool halves = true;   // false: halves of what came before did not help
    bool breaks = true;   // false: it ends where a link breaks
    bool rough = false;   // true: what is not solved is taken as it is

    Piece first(double length) const {
        Piece piece = *this;
        piece.dt = length;
        return piece;
    }
    Piece rest(double length) const {
        Piece piece = *this;
        piece.begin = begin + length;
        piece.dt = dt - length;
        piece.ground = ground.later(length);
        return piece;
    }
    /// The same, all at once.
    Piece whole() const {
        Piece piece = *this;
        piece.cuts = 0;
        piece.halves = true;
        return piece;
    }
};

/// A step of some bodies. What belongs to bodies is numbered as in the world.
template <int d> struct Step {
    Piece<d> piece;
    Vec<d> load{};                            // mean acceleration of gravity less that of the ground, m/s2
    double pull = 0;                          // most of it, m/s2
    std::vector<int> members, listed;         // bodies that move; with all fixed ones

    std::vector<PlacedBody<d>> start, other;  // at the start; where contacts are looked for besides
    std::vector<Placement<d>> end;
    std::vector<Motion<d>> begun, w;          // sums of the velocities at both ends: at first twice those at the start
    std::vector<Motion<d>> free;              // of a platform: w without contacts
    std::vector<MotionMatrix<d>> mass, inverse_mass;
    std::vector<double> margin, least, way;   // in which contacts are looked for; its least; how far the body goes, m
    std::vector<char> still, failed;
    bool all_still = true;

    std::vector<Contact<d>> contacts, links;
    std::vector<LinkStep<d>> link_steps;
    std::vector<std::pair<int, int>> pairs;   // bodies that may touch
    std::vector<double> apart;                // of each pair at the start, m
    std::vector<std::size_t> first;           // contact of each pair; last of all the first that turned out later
    Islands<d> islands;

    /// Begins a step of some bodies, with margins by their velocities alone.
    void begin(const World<d>& world, const std::vector<int>& some, const Piece<d>& of) {
        const auto resize = [&](auto&... of_bodies) { (of_bodies.resize(world.bodies.size()), ...); };
        resize(margin, least, way, still, failed, start, other, end, w, begun, mass, inverse_mass, free);
        piece = of;
        pull = norm(world.gravity - piece.ground.start) + piece.dt * norm(piece.ground.rise);
        members = some;
        listed = members;
        listed.insert(listed.end(), world.fixed.begin(), world.fixed.end());
        for (int b : members) least[b] = 0;
    }

    /// Writes places, velocities, masses and margins at the start.
    void set_out(const World<d>& world) {
        for (int b : world.fixed) {
            start[b].place(world.shapes, world.bodies[b].parts, world.bodies[b].placement());
            end[b] = start[b].at;
            margin[b] = world.hair();
            still[b] = 1;
            failed[b] = 0;
            w[b].fill(0);
        }
        for (int b : members) {
            const Body<d>& body = world.bodies[b];
            start[b].place(world.shapes, body.parts, body.placement());
            failed[b] = 0;
            way[b] = 0;
            w[b] = begun[b] = 2.0 * body.velocities(start[b].at.R);
            body.write_mass(start[b].at.R, mass[b], inverse_mass[b]);
        }
        find_links(world);
        set_length(world, piece.dt);
        all_still = true;
        for (int b : members) {
            const Body<d>& body = world.bodies[b];
            double pushed = norm(load);
            for (int i : world.forces_on[b]) pushed += std::max(norm(world.forces[i].start), norm(world.forces[i].end)) / body.mass;
            const double goes = piece.dt * (norm(body.v) + norm(body.spin) * body.radius + piece.dt * pushed);
            margin[b] = std::max(least[b], 2 * goes + world.hair());
            still[b] = std::max(0.5 * least[b], goes) < 100 * world.hair();
            all_still &= still[b] != 0;
        }
    }

    /// Lets the step be of a length, with the bodies and contacts that there are.
    void set_length(const World<d>& world, double dt) {
        piece.dt = dt;
        load = world.gravity - piece.ground.mean(dt);
        for (LinkStep<d>& each : link_steps) each.dt = dt;
        for (int b : members)
            if (world.bodies[b].is_platform()) set_platform(world.bodies[b], world.scheme, load, dt, free[b], mass[b], inverse_mass[b]);
    }

    /// Mean of an applied force over the step, N.
    Vec<d> mean_force(const World<d>& world, const AppliedForce<d>& force) const {
        return force.at((piece.begin + 0.5 * piece.dt - world.time) / world.whole);
    }

    /// Takes some bodies to where they end by their motions.
    void place_ends(const World<d>& world, const std::vector<int>& some) {
        for (int b : some) end[b] = world.bodies[b].moved(0.5 * piece.dt * w[b]);
    }

    /// Writes the rows of a contact or a link from the start of the step to its end.
    void write_rows(const World<d>& world, Contact<d>& k) const {
        const int a = k.feature.point_body, b = k.feature.face_body;
        world.write_rows(k, start[a].at, end[a], start[b].at, end[b]);
    }

    /// Writes the rows of a contact as it is at the start.
    void write_rows_at_start(const World<d>& world, Contact<d>& k) const {
        const Placement<d>&a = start[k.feature.point_body].at, &b = start[k.feature.face_body].at;
        world.write_rows(k, a, a, b, b);
    }

    /// Where a contact is at the start, m.
    Vec<d> place(const World<d>& world, const Contact<d>& k) const {
        const Feature<d>& feature = k.feature;
        return place_of(feature, world.point_shape(feature), world.face_shape(feature), start[feature.point_body].at, start[feature.face_body].at);
    }

    /// Gap of a feature at the end, m.
    double end_gap(const World<d>& world, const Feature<d>& feature) const {
        return world.gap(feature, end[feature.point_body], end[feature.face_body]);
    }

    /// What a contact does by motions of its bodies, by its rows.
    static Vec<d> moved(const Contact<d>& k, const std::vector<Motion<d>>& motions) {
        return mul(k.rows_a, motions[k.feature.point_body]) + mul(k.rows_b, motions[k.feature.face_body]);
    }

    /// Adds the way of a contact along its face in the step, in space, times a factor.
    void add_slip(const Contact<d>& k, double factor, Vec<d>& slip) const {
        const Vec<d> way_of = moved(k, w);
        for (int i = 1; i < d; i++) slip += (factor * 0.5 * piece.dt * way_of[i]) * k.axis(i);
    }

  private:
    /// The links of the members that are not broken, as contacts of the local problem.
    void find_links(const World<d>& world) {
        links.clear();
        link_steps.clear();
        if (world.links.empty()) return;
        link_steps.reserve(world.links.size());  // contacts point into it
        std::vector<char> is_member(world.bodies.size(), 0);
        for (int b : members) is_member[b] = 1;
        for (const Link<d>& link : world.links) {
            if (link.broken || !(is_member[link.a] || is_member[link.b])) continue;
            link_steps.push_back({&link, piece.dt});
            Contact<d> k{};
            k.link = &link_steps.back();
            k.feature.point_body = link.b;
            k.feature.face_body = link.a;
            k.law = &world.laws[0];
            links.push_back(k);
        }
    }
};

}  // namespace rockslip
