// A world of rigid bodies: what there is, where it stands, and what its steps tell.
//
// `stepper.hpp` steps it.
#pragma once

#include "collision.hpp"
#include "contact_memory.hpp"
#include "platform.hpp"
#include "support.hpp"
#include "touching_pairs.hpp"

namespace rockslip {

/// How deep two bodies overlap, and when.
struct Overlap {
    double depth = 0;  // m
    double time = 0;   // of the start of the step, s
    int a = -1, b = -1;
};

struct StepCounts {
    long outer = 0, late = 0, widened = 0, halved = 0, cut = 0, contacts = 0, most_contacts = 0, unsettled = 0;
    long rungs[5] = {0, 0, 0, 0, 0};
};

/// Bodies of which every one may meet every other, with their links, forces and laws of contact.
template <int d> struct World {
    static constexpr int dimension = d;

    std::vector<Shape<d>> shapes;
    std::vector<Body<d>> bodies;
    std::vector<ContactLaw> laws;
    std::vector<int> law_of;              // number of the law of each pair of bodies, (n, n)
    std::vector<Link<d>> links;
    std::vector<AppliedForce<d>> forces;
    Vec<d> gravity{};
    Scheme scheme;
    bool velocity_level = true;

    double time = 0;                      // of the start of the step under way, s
    double whole = 0;                     // its length, s
    long number = 0;                      // its number
    ContactMemory<d> memory;

    Ledger ledger;
    std::vector<Collision<d>> collisions;
    Support<d> support;
    TouchingPairs<d> pairs;
    Overlap deepest;                      // of two bodies at the start of any step so far
    Vec<d> ground_impulse{};              // of the platform's spring and dashpot on the ground in a step, N s
    StepCounts counts;

    double size = 1;                      // mean diameter of what is free, m: lengths are small or not against it
    std::vector<int> moving, fixed;       // numbers of bodies
    std::vector<std::vector<int>> forces_on;  // numbers of the forces on each body

    /// To be called once, when all bodies are there.
    void begin() {
        for (Body<d>& body : bodies) {
            for (int i : body.parts) body.radius = std::max(body.radius, shapes[i].radius);
            for (int i : body.parts)
                for (int j : body.parts)
                    if (i != j) mark_inner(shapes[i], shapes[j], COVERED * body.radius);
            body.turned = rotation_vector(body.rotation, {});
        }
        double sum = 0;
        std::size_t free = 0;
        for (const Body<d>& body : bodies)
            if (body.is_free()) {
                sum += 2 * body.radius;
                free++;
            }
        size = free ? sum / static_cast<double>(free) : 1;
        support.begin(bodies);
        for (std::size_t b = 0; b < bodies.size(); b++) (bodies[b].moves() ? moving : fixed).push_back(static_cast<int>(b));
        forces_on.assign(bodies.size(), {});
        for (std::size_t i = 0; i < forces.size(); i++) forces_on[forces[i].body].push_back(static_cast<int>(i));
        for (Link<d>& link : links) link.extension = extension_of(link);
    }

    double hair() const { return 1e-6 * size; }        // for deciding which corners count
    double round_off() const { return 1e-12 * size; }  // gaps below are none
    double touching() const { return 1e-9 * size; }    // contacts closer than this touch already

    const ContactLaw& law(int a, int b) const {
        return laws[law_of[static_cast<std::size_t>(a) * bodies.size() + static_cast<std::size_t>(b)]];
    }

    const Shape<d>& part(int body, std::size_t which) const { return shapes[bodies[body].parts[which]]; }
    const Shape<d>& point_shape(const Feature<d>& feature) const { return part(feature.point_body, feature.point_part); }
    const Shape<d>& face_shape(const Feature<d>& feature) const { return part(feature.face_body, feature.face_part); }

    Vec<d> extension_of(const Link<d>& link) const { return link.measure(bodies[link.a].placement(), bodies[link.b].placement()); }

    /// Gap of a feature for its bodies at two places.
    double gap(const Feature<d>& feature, const Placement<d>& a, const Placement<d>& b) const {
        return gap_of(feature, point_shape(feature), face_shape(feature), a, b);
    }

    /// Writes the rows of a contact or a link, for motions of the bodies of its point and its face from places a0, b0 to
    /// a1, b1.
    void write_rows(Contact<d>& k, const Placement<d>& a0, const Placement<d>& a1, const Placement<d>& b0, const Placement<d>& b1) const {
        if (k.link) write_link_rows(k, b0, b1, a0, a1);
        else write_contact_rows(k, point_shape(k.feature), face_shape(k.feature), a0, a1, b0, b1);
        if (bodies[k.feature.point_body].is_platform()) restrict_to_platform<d>(k.rows_a);
        if (bodies[k.feature.face_body].is_platform()) restrict_to_platform<d>(k.rows_b);
    }

    /// Kinetic, gravity and spring energy, J.
    std::array<double, 3> energies() const {
        std::array<double, 3> e{0, 0, 0};
        for (const Body<d>& body : bodies) {
            if (!body.moves()) continue;
            e[0] += body.kinetic_energy();
            e[1] -= body.mass * dot(gravity, body.x);
            e[2] += 0.5 * body.stiffness * dot(body.x, body.x);
        }
        for (const Link<d>& link : links) e[2] += link.energy();
        return e;
    }

    /// Number of contacts that were closed at the end of the last step.
    int closed_contacts() const { return memory.closed_at(number); }

    /// Passes all that steps change to an archive, which reads or writes numbers.
    template <class Archive> void exchange(Archive& archive) {
        archive(time, number, deepest.depth, deepest.time, deepest.a, deepest.b, ledger.input, ledger.friction, ledger.damping, ledger.contact, ledger.numerical);
        for (Body<d>& body : bodies) archive(body.x, body.v, body.rotation.value, body.spin, body.turned, body.spring_force);
        for (Vec<d>& each : support.slip) archive(each);
        for (Link<d>& link : links) archive(link.plastic, link.force, link.extension, link.broken, link.broken_at, link.lost);
        archive.size(pairs.all);
        for (TouchingPair<d>& pair : pairs.all) archive(pair.a, pair.b, pair.points, pair.normal, pair.impulse, pair.gap, pair.place, pair.pressed, pair.slip);
        auto& remembered = memory.pairs();
        archive.size(remembered);
        for (auto& pair : remembered) {
            archive(pair.a, pair.b);
            archive.size(pair.contacts);
            for (Remembered<d>& each : pair.contacts) {
                archive(each.id, each.impulse, each.velocity_impulse, each.offset, each.gap, each.closed, each.step);
                archive(each.friction.rate, each.friction.slipped, each.friction.broken);
            }
        }
    }

  private:
    static constexpr double COVERED = 1e-9;  // of the radius of a body: parts this close touch
};

}  // namespace rockslip
