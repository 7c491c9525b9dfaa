// Rigid bodies in contact, and a step through them.
//
// Every body may meet every other. With w = v_n + v_{n+1} = 2 du/dt a step of generalized-alpha reads
// (M54) M (w - w_free) = G_m^T P and y = (2/dt) (gap, place)_{n+1} = c + G_m w with the rows of the middle of
// the step: the same problem as that of velocities, M (v - v_free) = G^T P with v_n complementary to
// P_n, so that one solver serves both. Impulses act at the end of the step, outside any average.
//
// Bodies near each other make groups. A group in which something touches hard, or stops to slide, is
// stepped to that instant and on from there; one whose contact is not solved, in halves.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <tuple>

#include "broad_phase.hpp"
#include "local_problem.hpp"

namespace rockslip {

/// What was taken in and lost since the start, J.
struct Ledger {
    double input = 0;      // work of the moving ground
    double friction = 0;
    double damping = 0;    // of the platform's dashpot; of dashpots, flow and fracture of links
    double contact = 0;    // impacts and the velocity level
    double numerical = 0;  // time stepping of the platform
};

/// A force on a body at a point of it, along directions in space.
template <int d> struct AppliedForce {
    int body = 0;
    Vec<d> arm{};         // of the point from the centre, in the frame of the body, m
    Vec<d> start{}, end{};  // at both ends of a step, in between linear, N
};

/// Two bodies that met at an instant, over all points at which they did.
template <int d> struct Collision {
    double time = 0;         // s
    int a = 0, b = 0;        // a < b
    int points = 0;
    Vec<d> place{};          // mean of the points by their normal impulses, m
    Vec<d> normal{};         // mean, likewise, from b to a
    double approach = 0;     // largest normal velocity before, m/s
    double departure = 0;    // and the largest after
    double brought = 0;      // part of the approach that a brings, where it is largest, m/s
    Vec<Dim<d>::rotations> spin{};       // of a against b before, in space, rad/s
    Vec<Dim<d>::rotations> later_spin{};  // and after; nan where a step was not cut there
    Vec<d> impulse{};        // on a, N s
    double energy = 0;       // lost by the impulses of this pair, J
};

/// What two bodies that have ever touched do to one another, in the frame of their mean normal.
template <int d> struct PairTold {
    int a = 0, b = 0;        // a < b
    int points = 0;          // closed at the end of the step
    Vec<d> normal{};         // mean by the points, from b to a; as it was where nothing touches
    Vec<d> impulse{};        // of the step on a, N s
    double gap = 0;          // at the end of the step, along the axis that separates them best, m
    Vec<d> place{};          // where they press, mean by normal impulses, m; as it was where they do not
    double pressed = 0;      // normal impulses so far, N s
    Vec<d> slip{};           // of a over b in contact, along the tangents of all steps, m; the first is unused
};

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

template <int d> class World {
    static constexpr int unknowns = Dim<d>::unknowns, rotations = Dim<d>::rotations;
    using Motion = Vec<unknowns>;
    using Square = Mat<unknowns, unknowns>;
    using C = Contact<d>;

  public:
    static constexpr int dimension = d;
    std::vector<Shape<d>> shapes;
    std::vector<Body<d>> bodies;
    std::vector<ContactLaw> laws;
    std::vector<Link<d>> links;
    std::vector<AppliedForce<d>> forces;
    std::vector<int> law_of;              // number of the law of each pair of bodies, (n, n)
    std::vector<std::vector<int>> carriers;  // of each body: what its slip is measured over
    Vec<d> gravity{};
    Scheme scheme;
    bool velocity_level = true;

    double time = 0;
    Ledger ledger;
    std::vector<Collision<d>> collisions;
    std::vector<Vec<d>> slip;             // of each body over what carries it, m, (n,); the last is unused
    std::vector<Vec<d>> received;         // impulses of a step on each body from what it stands on, N s
    std::vector<Vec<d>> part_received;    // of a step on the parts of all bodies that have several, one body after another, N s
    std::vector<double> penetration;      // of each body in any but what it carries, m
    Overlap deepest;                      // of two bodies at the start of any step so far
    bool tells_pairs = false;
    std::vector<PairTold<d>> told;        // pairs that have ever touched, where they are told
    Vec<d> spring_impulse{};              // of the platform's spring and dashpot on the ground in a step, N s
    LocalProblem<d> local;
    StepCounts counts;

    /// To be called once, when all bodies are there.
    void begin() {
        const std::size_t count = bodies.size();
        for (Body<d>& body : bodies) {
            for (int i : body.parts) body.radius = std::max(body.radius, shapes[i].radius);
            for (int i : body.parts)
                for (int j : body.parts)
                    if (i != j) mark_inner(shapes[i], shapes[j], COVERED * body.radius);
            first_part_.push_back(body.parts.size() > 1 ? static_cast<int>(part_received.size()) : -1);
            if (body.parts.size() > 1) part_received.resize(part_received.size() + body.parts.size());
        }
        double sum = 0;
        std::size_t free = 0;
        for (const Body<d>& body : bodies)
            if (body.mobility == Mobility::FREE) {
                sum += 2 * body.radius;
                free++;
            }
        size_ = free ? sum / static_cast<double>(free) : 1;
        slip.assign(count, {});
        received.assign(count, {});
        penetration.assign(count, 0);
        carriers.resize(count);
        moving_.clear();
        fixed_.clear();
        for (std::size_t b = 0; b < count; b++) {
            (bodies[b].moves() ? moving_ : fixed_).push_back(static_cast<int>(b));
            bodies[b].turned = rotation_vector(bodies[b].rotation, {});
        }
        forces_on_.assign(count, {});
        for (std::size_t i = 0; i < forces.size(); i++) forces_on_[forces[i].body].push_back(static_cast<int>(i));
        for (Link<d>& link : links) link.extension = link.measure(bodies[link.a].placement(), bodies[link.b].placement());
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

    /// One step; false where no step, however short, was solved.
    bool step(double dt, double smallest, const GroundMotion<d>& ground) {
        for (Vec<d>& each : received) each.fill(0);
        for (Vec<d>& each : part_received) each.fill(0);
        for (PairTold<d>& pair : told) {
            pair.points = 0;
            pair.impulse.fill(0);
            pair.pressed = 0;
        }
        std::fill(penetration.begin(), penetration.end(), 0.0);
        spring_impulse.fill(0);
        for (Link<d>& link : links) link.mean.fill(0);
        smallest_ = smallest;
        whole_ = dt;
        number_++;
        const double begin = time, end = time + dt;
        const bool solved = advance(0, moving_, {time, dt, ground, CUTS});
        if (solved) time = end;
        for (Link<d>& link : links)  // in the step in which it breaks it keeps the extension that it broke at
            if (link.broken && link.broken_at <= begin) link.extension = link.measure(bodies[link.a].placement(), bodies[link.b].placement());
        if (number_ % 64 == 0) memory_.forget_before(number_ - 2);
        if (tells_pairs) measure_pairs();
        return solved;
    }

    /// Number of contacts that were closed at the end of the last step.
    int closed_contacts() {
        int closed = 0;
        for (const auto& pair : memory_.pairs())
            for (const Remembered<d>& each : pair.contacts) closed += each.closed && each.step == number_;
        return closed;
    }

    /// First and, in space, second tangent of a pair: y x n and n x (y x n), clockwise from n in the plane.
    static std::array<Vec<d>, d - 1> tangents(const Vec<d>& n) {
        if constexpr (d == 2) return {Vec<2>{n[1], -n[0]}};
        else {
            const Vec<3> along = std::fabs(n[1]) < 0.9 ? Vec<3>{n[2], 0, -n[0]} : Vec<3>{n[1], -n[0], 0};
            const Vec<3> first = (1 / norm(along)) * along;
            return {first, cross(n, first)};
        }
    }

    /// Passes all that steps change to an archive, which reads or writes numbers.
    template <class Archive> void exchange(Archive& archive) {
        archive(time, number_, deepest.depth, deepest.time, deepest.a, deepest.b, ledger.input, ledger.friction, ledger.damping, ledger.contact, ledger.numerical);
        for (Body<d>& body : bodies) archive(body.x, body.v, body.rotation.value, body.spin, body.turned, body.spring_force);
        for (Vec<d>& each : slip) archive(each);
        for (Link<d>& link : links) archive(link.plastic, link.force, link.extension, link.broken, link.broken_at, link.lost);
        archive.size(told);
        for (PairTold<d>& pair : told) archive(pair.a, pair.b, pair.points, pair.normal, pair.impulse, pair.gap, pair.place, pair.pressed, pair.slip);
        auto& pairs = memory_.pairs();
        archive.size(pairs);
        for (auto& pair : pairs) {
            archive(pair.a, pair.b);
            archive.size(pair.contacts);
            for (Remembered<d>& each : pair.contacts) {
                archive(each.id, each.impulse, each.velocity_impulse, each.offset, each.gap, each.closed, each.step);
                archive(each.friction.rate, each.friction.slipped, each.friction.broken);
            }
        }
    }

  private:
    static constexpr double INSET = 1e-6;       // of the size: for deciding which corners count
    static constexpr double ROUND_OFF = 1e-12;  // of the size: gaps below are none
    static constexpr double TOUCHING = 1e-9;    // of the size: contacts closer than this touch already
    static constexpr double LANDING = 1e-8;     // of the size: contacts closer than this land together
    static constexpr double SMALLEST_PIECE = 1e-3;  // of a step, before or after an end of slip
    static constexpr double AT_END = 1e-9;          // of a step: touches this close to its ends are there
    static constexpr double FLOWN = 1e-12;          // of the motion of a body: changes below are none
    static constexpr double ROWS = 1e-14;           // of the size in a whole step: errors of rows below are none
    static constexpr double COVERED = 1e-9;  // of the radius of a body: parts this close touch
    static constexpr double STOPPED = 1e-6;
    static constexpr double BREAKING = 1e-9;  // of the strength of a link
    static constexpr double FRACTURE = 1e-6;  // of it, where events before change the instant
    static constexpr double PIVOT = 1e-6;  // of the speed of a landing: slower contacts are its pivots
    static constexpr double SLOW = 1e-3;
    static constexpr double STEEPEST = 0.5;  // upward component of the normal of what bears a body
    // Friction that falls with speed follows it all the way, then half the way, at last not at all.
    static constexpr int FRICTION_ROUNDS = 40;
    static constexpr std::array<double, 3> SHARES{1.0, 0.5, 0.0};
    static constexpr int CUTS = 5, LOCATING = 30, MOST_WIDENED = 3;
    static constexpr int MOST_ROUGH = 16;   // parts of a step in which halves do not help
    static constexpr int LARGEST_CUT = 12;  // bodies of a group that is cut where nothing rebounds

    /// All that belongs to one attempt to step some bodies.
    struct Attempt {
        std::vector<int> members, listed;          // bodies that move; with all fixed ones
        std::vector<double> margin, least, way;    // by body
        std::vector<char> still, failed;
        std::vector<PlacedBody<d>> start, other;
        std::vector<Placement<d>> end;
        std::vector<Motion> w, begun;
        std::vector<Square> mass, inverse_mass;
        std::vector<Motion> free;
        double begin = 0;  // s
        std::vector<C> contacts, links;
        std::vector<LinkStep<d>> link_steps;
        std::vector<Feature<d>> found;
        std::vector<std::pair<int, int>> pairs;
        std::vector<double> apart;
        std::vector<std::size_t> first;  // contact of each pair; last of all the first that turned out later
        std::vector<Island<d>> islands;
        int island_count = 0;
        bool all_still = true;
    };

    Attempt& attempt(int depth) {
        while (static_cast<int>(attempts_.size()) <= depth) attempts_.emplace_back();
        Attempt& A = attempts_[depth];
        const std::size_t count = bodies.size();
        const auto resize = [count](auto&... of_bodies) { (of_bodies.resize(count), ...); };
        resize(A.margin, A.least, A.way, A.still, A.failed, A.start, A.other, A.end, A.w, A.begun, A.mass, A.inverse_mass, A.free);
        return A;
    }

    const ContactLaw& law(int a, int b) const {
        return laws[law_of[static_cast<std::size_t>(a) * bodies.size() + static_cast<std::size_t>(b)]];
    }

    /// A step or a piece of one: when it begins (s), its length (s), and the motion of the ground.
    struct Piece {
        double begin, dt;
        GroundMotion<d> ground;
        int cuts;  // how often it may be cut at an event
        bool halves = true;  // false: halves of what came before did not help
        bool breaks = true;  // false: it ends where a link breaks

        Piece first(double length) const { return {begin, length, ground, cuts, halves, breaks}; }
        Piece rest(double length) const { return {begin + length, dt - length, ground.later(length), cuts, halves, breaks}; }
    };

    // ------------------------------------------------------------ one attempt

    /// Steps some bodies; where that needs it, in groups and in pieces.
    bool advance(int depth, const std::vector<int>& members, const Piece& piece) {
        const auto& [begin, dt, ground, cuts, halves, breaks] = piece;
        Attempt& A = attempt(depth);
        A.members = members;
        A.begin = begin;
        for (int b : members) A.least[b] = 0;
        for (int wider = 0;; wider++) {
            set_out(A, dt, ground);
            find_contacts(A, dt, ground);
            const bool strayed = solve(A, dt, ground);
            if (!strayed || wider == MOST_WIDENED) break;
            counts.widened++;
        }
        bool any_failed = false;
        for (int b : members) any_failed |= A.failed[b];
        const double pull = norm(gravity - ground.start) + dt * norm(ground.rise);
        const bool cuttable = cuts > 0 && (something_happens(A, dt, pull) || (breaks && any_breaks(A)));
        if (!any_failed && !cuttable) {
            finish(A, piece);
            return true;
        }
        const std::vector<std::vector<int>> groups = groups_of(A);
        if (groups.size() > 1) return by_groups(A, depth, groups, piece, pull);
        if (any_failed) return by_halves(A, depth, piece);
        if (is_cut(A, piece, pull)) return in_pieces(A, depth, piece, pull);
        finish(A, piece);
        return true;
    }

    /// Places, velocities and margins at the start.
    void set_out(Attempt& A, double dt, const GroundMotion<d>& ground) {
        A.listed = A.members;
        A.listed.insert(A.listed.end(), fixed_.begin(), fixed_.end());
        A.all_still = true;
        find_links(A);
        const Vec<d> load = gravity - ground.mean(dt);
        const double pull = norm(load), hair = INSET * size_;
        for (int b : fixed_) {
            A.start[b].place(shapes, bodies[b].parts, bodies[b].placement());
            A.end[b] = A.start[b].at;
            A.margin[b] = hair;
            A.still[b] = 1;
            A.failed[b] = 0;
            A.w[b].fill(0);
        }
        for (int b : A.members) {
            const Body<d>& body = bodies[b];
            A.start[b].place(shapes, body.parts, body.placement());
            A.failed[b] = 0;
            A.way[b] = 0;
            double pushed = pull;
            for (int i : forces_on_[b]) pushed += std::max(norm(forces[i].start), norm(forces[i].end)) / body.mass;
            const double way = dt * (norm(body.v) + norm(body.spin) * body.radius + dt * pushed);
            A.margin[b] = std::max(A.least[b], 2 * way + hair);
            A.still[b] = std::max(0.5 * A.least[b], way) < 100 * hair;
            A.all_still &= A.still[b] != 0;
            const auto spin = to_space(A.start[b].at.R, body.spin);
            for (int i = 0; i < d; i++) A.w[b][i] = 2 * body.v[i];
            for (int i = 0; i < rotations; i++) A.w[b][d + i] = 2 * spin[i];
            A.begun[b] = A.w[b];
            set_mass(b, A.start[b].at.R, A.mass[b], A.inverse_mass[b]);
            if (body.is_platform()) set_platform(A, b, dt, ground);
        }
    }

    /// M and its inverse about the axes of space.
    void set_mass(int b, const Mat<d, d>& R, Square& M, Square& inverse) const {
        const Body<d>& body = bodies[b];
        M = {};
        inverse = {};
        for (int i = 0; i < unknowns; i++) M[i][i] = inverse[i][i] = 1;  // unknowns that a platform lacks
        for (int i = 0; i < (body.is_platform() ? d - 1 : d); i++) {
            M[i][i] = body.mass;
            inverse[i][i] = 1 / body.mass;
        }
        if (body.is_platform()) return;
        for (int i = 0; i < rotations; i++)
            for (int j = 0; j < rotations; j++) {
                double direct = 0, reciprocal = 0;
                for (int k = 0; k < rotations; k++)
                    for (int l = 0; l < rotations; l++) {
                        const double turn = d == 2 ? 1 : R[i][k] * R[j][l];
                        direct += turn * body.inertia[k][l];
                        reciprocal += turn * body.inverse_inertia[k][l];
                    }
                M[d + i][d + j] = direct;
                inverse[d + i][d + j] = reciprocal;
            }
    }

    /// The effective mass of a platform on its spring, and its motion without contacts (M57).
    void set_platform(Attempt& A, int b, double dt, const GroundMotion<d>& ground) const {
        const Body<d>& body = bodies[b];
        const double weight = 0.5 * (1 - scheme.alpha_m) / scheme.beta;
        const double inertial = (1 - scheme.alpha_m) / (scheme.beta * dt * dt) * body.mass;
        const double stiffness = inertial + (1 - scheme.alpha_f) * body.stiffness + weight * body.damping / dt;
        const double later = (1 - scheme.alpha_m) * (0.5 / scheme.beta - 1) - scheme.alpha_m;
        const Vec<d> load = body.mass * (gravity - ground.mean(dt));
        A.free[b].fill(0);
        for (int i = 0; i + 1 < d; i++) {
            const double right = weight * load[i] - body.stiffness * body.x[i] + inertial * dt * body.v[i] + later * body.spring_force[i];
            A.free[b][i] = 2 / dt * right / stiffness;
            A.inverse_mass[b][i][i] = 2 / (dt * dt) * weight / stiffness;
            A.mass[b][i][i] = 1 / A.inverse_mass[b][i][i];
        }
    }

    /// The links of the members that are not broken, as contacts of the local problem.
    void find_links(Attempt& A) {
        A.links.clear();
        A.link_steps.clear();
        if (links.empty()) return;
        A.link_steps.reserve(links.size());  // contacts point into it
        is_member_.assign(bodies.size(), 0);
        for (int b : A.members) is_member_[b] = 1;
        for (const Link<d>& link : links) {
            if (link.broken || !(is_member_[link.a] || is_member_[link.b])) continue;
            A.link_steps.push_back({&link, 0});
            C k{};
            k.link = &A.link_steps.back();
            k.feature.point_body = link.b;
            k.feature.face_body = link.a;
            k.law = &laws[0];
            A.links.push_back(k);
        }
    }

    /// Impulses and moments of the forces on a body in a step, by their means over it.
    Motion pushed(const Attempt& A, int b, double dt) const {
        Motion pushed{};
        for (int i : forces_on_[b]) {
            const Vec<d> force = mean_force(A, forces[i], dt);
            const auto turn = moment(mul(mean(A.start[b].at.R, A.end[b].R), forces[i].arm), force);
            for (int j = 0; j < d; j++) pushed[j] += dt * force[j];
            for (int j = 0; j < rotations; j++) pushed[d + j] += dt * turn[j];
        }
        return pushed;
    }

    Vec<d> mean_force(const Attempt& A, const AppliedForce<d>& force, double dt) const {
        const double share = (A.begin + 0.5 * dt - time) / whole_;
        return force.start + share * (force.end - force.start);
    }

    /// Motion of a free body without contacts, for M (w - w_free) = its impulses and moments by them.
    ///
    /// In space it is Newton's method for the energy-momentum rule on the angular momentum (Simo and Wong
    /// 1991) about the last iterate and what contacts did to it, `touched` (M56).
    Motion free_motion(const Attempt& A, int b, double dt, const Vec<d>& load, const Motion& touched) const {
        const Body<d>& body = bodies[b];
        Motion free = mul(A.inverse_mass[b], pushed(A, b, dt));
        for (int i = 0; i < d; i++) free[i] += 2 * body.v[i] + dt * load[i];
        if constexpr (d == 2) {
            free[2] += 2 * body.spin[0];
        } else {
            const Mat<3, 3>&R = A.start[b].at.R, &J = body.inertia;
            const Motion given = touched + pushed(A, b, dt);
            const Vec<3> turn{A.w[b][3], A.w[b][4], A.w[b][5]}, psi = to_body(R, 0.5 * dt * turn);
            const Vec<3> moment = to_body(R, {dt * given[3], dt * given[4], dt * given[5]});
            const Vec<3> rule = 2.0 * mul(J, psi - dt * body.spin) + cross(psi, mul(J, psi));
            Vec<3> change = moment - 0.5 * cross(psi, moment) - rule;
            const Vec<3> momentum = mul(J, psi) + 0.5 * moment;
            LU<3> tangent;
            for (int j = 0; j < 3; j++) {
                Vec<3> unit{}, column;
                unit[j] = 1;
                for (int i = 0; i < 3; i++) column[i] = J[i][j];
                column = 2.0 * column + cross(psi, column) - cross(momentum, unit);
                for (int i = 0; i < 3; i++) tangent.a[i][j] = column[i];
            }
            if (tangent.factorize()) tangent.solve(change);
            else change.fill(NAN);
            change = to_space(R, (2 / dt) * change);
            for (int i = 0; i < 3; i++) {
                free[3 + i] = turn[i] + change[i];
                for (int j = 0; j < 3; j++) free[3 + i] -= A.inverse_mass[b][3 + i][3 + j] * touched[3 + j];
            }
        }
        return free;
    }

    // ------------------------------------------------------------ contacts

    void find_contacts(Attempt& A, double dt, const GroundMotion<d>& ground) {
        A.pairs = broad_.find(A.listed, bodies, A.start, A.margin);
        A.apart.resize(A.pairs.size());
        A.contacts.clear();
        A.first.clear();
        if (!A.all_still) {
            const Vec<d> load = gravity - ground.mean(dt);
            for (int b : fixed_) A.other[b] = A.start[b];
            for (int b : A.members) {
                Motion increment = 0.5 * dt * A.w[b];
                if (!bodies[b].is_platform())
                    for (int i = 0; i < d; i++) increment[i] += 0.5 * dt * dt * load[i];
                A.other[b].place(shapes, bodies[b].parts, bodies[b].moved(increment));
            }
        }
        for (std::size_t i = 0; i < A.pairs.size(); i++) {
            const auto [a, b] = A.pairs[i];
            A.first.push_back(A.contacts.size());
            A.found.clear();
            A.apart[i] = look(A, A.pairs[i], A.start, true);
            if (-A.apart[i] > deepest.depth) deepest = {-A.apart[i], time, a, b};
            for (const Feature<d>& feature : A.found) add_contact(A, feature);
            if (A.still[a] && A.still[b]) continue;
            A.found.clear();
            look(A, A.pairs[i], A.other, true);
            for (const Feature<d>& feature : A.found) add_late_contact(A, i, feature);
        }
        A.first.push_back(A.contacts.size());
    }

    /// Features of a pair at some places, added to those found; returns how far it is apart.
    double look(Attempt& A, const std::pair<int, int>& pair, const std::vector<PlacedBody<d>>& placed, bool with_margin) {
        const auto [a, b] = pair;
        return look(a, b, placed[a], placed[b], with_margin ? A.margin[a] + A.margin[b] : 0, A.found);
    }

    /// Features of two bodies nearer than a margin, added to those found; returns how far they are apart along
    /// the axis that separates best those of their parts which are nearest.
    double look(int a, int b, const PlacedBody<d>& at_a, const PlacedBody<d>& at_b, double margin, std::vector<Feature<d>>& found) const {
        double least = INFINITY;
        for (std::size_t i = 0; i < at_a.parts.size(); i++)
            for (std::size_t j = 0; j < at_b.parts.size(); j++) {
                const PlacedShape<d>&one = at_a.parts[i], &other = at_b.parts[j];
                if (at_a.parts.size() + at_b.parts.size() > 2 && are_apart(one, other, margin)) continue;
                const std::size_t before = found.size();
                NarrowPhase<d> narrow(a, b, part(a, i), part(b, j), one, other, margin, INSET * size_, found);
                least = std::min(least, narrow.find());
                for (std::size_t f = before; f < found.size(); f++) {
                    const bool first = found[f].point_body == a;
                    found[f].point_part = static_cast<int>(first ? i : j);
                    found[f].face_part = static_cast<int>(first ? j : i);
                }
            }
        return least;
    }

    static bool are_apart(const PlacedShape<d>& one, const PlacedShape<d>& other, double margin) {
        for (int k = 0; k < d; k++)
            if (one.low[k] > other.high[k] + margin || other.low[k] > one.high[k] + margin) return true;
        return false;
    }

    const Shape<d>& part(int body, std::size_t number) const { return shapes[bodies[body].parts[number]]; }
    const Shape<d>& point_shape(const Feature<d>& feature) const { return part(feature.point_body, feature.point_part); }
    const Shape<d>& face_shape(const Feature<d>& feature) const { return part(feature.face_body, feature.face_part); }

    /// Adds a contact of a pair unless it is there, or was below its face, beside it, at the start; true
    /// where it is added.
    bool add_late_contact(Attempt& A, std::size_t pair, const Feature<d>& feature) {
        const int low = A.pairs[pair].first, high = A.pairs[pair].second;
        const std::uint64_t id = feature.id();
        const auto is_there = [&](std::size_t from, std::size_t to) {
            return std::any_of(A.contacts.begin() + from, A.contacts.begin() + to, [&](const C& k) {
                return k.id == id && std::minmax(k.feature.point_body, k.feature.face_body) == std::minmax(low, high);
            });
        };
        const std::size_t count = A.contacts.size(), end = pair + 1 < A.first.size() ? A.first[pair + 1] : count;
        if (is_there(A.first[pair], end) || is_there(std::max(end, A.first.back()), count)) return false;
        add_contact(A, feature);
        const C& k = A.contacts.back();
        const bool below = k.gap < -TOUCHING * size_ && !k.was_closed;
        if (below) A.contacts.pop_back();
        return !below;
    }

    void add_contact(Attempt& A, const Feature<d>& feature) {
        const auto [low, high] = std::minmax(feature.point_body, feature.face_body);
        const std::uint64_t id = feature.id();
        C k;
        k.feature = feature;
        k.id = id;
        k.law = &law(low, high);
        double gap = gap_between(feature, A.start[feature.point_body].at, A.start[feature.face_body].at);
        k.impulse.fill(0);
        k.velocity_impulse.fill(0);
        k.total.fill(0);
        k.start.fill(0);
        k.given.fill(0);
        k.was_closed = k.slips = k.closed = false;
        k.past = {};
        k.mode = FrictionMode::LAW;
        k.state = OPEN;
        if (const Remembered<d>* before = memory_.find(low, high, id)) {
            k.past = before->friction;
            if (before->step >= number_ - 1) {
                k.impulse = before->impulse;
                k.velocity_impulse = before->velocity_impulse;
                k.was_closed = before->closed;
                if (before->closed && std::fabs(gap - before->gap) < ROUND_OFF * size_) gap = before->gap;
                if (before->closed)
                    for (int i = 1; i < d; i++) k.start[i] = before->offset[i];
            }
        }
        // Contacts that say the same must not differ by round-off of places.
        if (std::fabs(gap) < ROUND_OFF * size_) gap = 0;
        k.gap = gap;
        k.start[0] = std::max(gap, 0.0);  // what has sunk in is held: pushed out it would gain energy
        k.area = feature.area;
        if constexpr (d == 2) k.area *= std::min(thickness(feature.point_body), thickness(feature.face_body));
        A.contacts.push_back(k);
    }

    double thickness(int b) const { return bodies[b].mobility == Mobility::FREE ? bodies[b].thickness : INFINITY; }

    double gap_between(const Feature<d>& feature, const Placement<d>& a, const Placement<d>& b) const {
        return gap_of(feature, point_shape(feature), face_shape(feature), a, b);
    }

    void write_contact_rows(C& k, const Placement<d>& a0, const Placement<d>& a1, const Placement<d>& b0, const Placement<d>& b1) const {
        const Body<d>&a = bodies[k.feature.point_body], &b = bodies[k.feature.face_body];
        write_rows(k, point_shape(k.feature), face_shape(k.feature), a0, a1, b0, b1);
        if (a.is_platform()) restrict_to_platform<d>(k.rows_a);
        if (b.is_platform()) restrict_to_platform<d>(k.rows_b);
    }

    /// Gathers bodies joined by all contacts and links.
    void gather_islands(Attempt& A) {
        gather_islands(A, [](const C&) { return true; }, true);
    }

    /// Gathers bodies joined by contacts, only those that `count`, and by links where wanted.
    template <class Counts> void gather_islands(Attempt& A, Counts count, bool with_links = false) {
        root_.resize(bodies.size());
        local_.resize(bodies.size());
        island_of_.resize(bodies.size());
        for (int b : A.members) {
            root_[b] = b;
            local_[b] = island_of_[b] = -1;
        }
        for (const C& k : A.contacts)
            if (count(k)) join(k);
        if (with_links)
            for (const C& k : A.links) join(k);
        A.island_count = 0;
        const auto take = [&](C& k) {
            const int a = k.feature.point_body, b = k.feature.face_body, root = top(bodies[a].moves() ? a : b);
            if (island_of_[root] < 0) {
                island_of_[root] = A.island_count++;
                if (static_cast<int>(A.islands.size()) < A.island_count) A.islands.emplace_back();
                A.islands[island_of_[root]].clear();
            }
            Island<d>& island = A.islands[island_of_[root]];
            for (int body : {a, b})
                if (bodies[body].moves() && local_[body] < 0) {
                    local_[body] = static_cast<int>(island.bodies.size());
                    island.bodies.push_back(body);
                }
            k.a = bodies[a].moves() ? local_[a] : -1;
            k.b = bodies[b].moves() ? local_[b] : -1;
            island.contacts.push_back(&k);
        };
        for (C& k : A.contacts)
            if (count(k)) take(k);
        if (with_links)
            for (C& k : A.links) take(k);
        for (int i = 0; i < A.island_count; i++) {
            Island<d>& island = A.islands[i];
            const std::size_t count_of = island.bodies.size();
            island.mass.resize(count_of);
            island.inverse_mass.resize(count_of);
            island.free.resize(count_of);
            island.w.resize(count_of);
        }
    }

    /// Puts both bodies of a contact into one set.
    void join(const C& k) {
        if (bodies[k.feature.point_body].moves() && bodies[k.feature.face_body].moves()) root_[top(k.feature.point_body)] = top(k.feature.face_body);
    }

    int top(int b) {
        while (root_[b] != b) b = root_[b] = root_[root_[b]];
        return b;
    }

    // ------------------------------------------------------------ solution of a step

    /// Solves all islands, with contacts that turn out later; marks bodies of those that have no
    /// solution. True where bodies went farther than anybody looked: margins are wider then.
    bool solve(Attempt& A, double dt, const GroundMotion<d>& ground) {
        for (int round = 0; round < 8; round++) {
            gather_islands(A);
            settle_all(A, dt, ground);
            bool strayed = false;
            for (int b : A.members) {
                if (A.failed[b]) continue;
                double turn = norm_from(A.w[b], d), go = 0;
                for (int i = 0; i < d; i++) go = std::hypot(go, A.w[b][i]);
                A.way[b] = 0.5 * dt * (go + turn * bodies[b].radius);
                if (!(A.way[b] > A.margin[b])) continue;
                strayed = true;
                A.least[b] = 2 * A.way[b];
            }
            const bool more = add_late_contacts(A);
            if (!more) return strayed;
        }
        return false;
    }

    /// Contacts that overlap at the end of the step though they were none; true where there are any.
    bool add_late_contacts(Attempt& A) {
        if (A.all_still) return false;
        for (int b : A.members) A.other[b].place(shapes, bodies[b].parts, A.end[b]);
        for (int b : fixed_) A.other[b] = A.start[b];
        bool more = false;
        for (std::size_t i = 0; i < A.pairs.size(); i++) {
            const auto [a, b] = A.pairs[i];
            if ((A.still[a] && A.still[b]) || A.failed[a] || A.failed[b]) continue;
            A.found.clear();
            const double apart = look(A, A.pairs[i], A.other, false);
            bool added = false;
            if (apart < -1e-10 * size_)
                for (const Feature<d>& feature : A.found)
                    if (gap_between(feature, A.end[feature.point_body], A.end[feature.face_body]) < -1e-11 * size_ && add_late_contact(A, i, feature)) {
                        counts.late++;
                        added = more = true;
                    }
            // Nobody can say where they met: a shorter step knows.
            if (!added && apart < std::min(A.apart[i], 0.0) - TOUCHING * size_) spoil(A, a), spoil(A, b);
        }
        return more;
    }

    void spoil(Attempt& A, int b) {
        if (bodies[b].moves() && !rough_) A.failed[b] = 1;
    }

    void settle_all(Attempt& A, double dt, const GroundMotion<d>& ground) {
        const Vec<d> load = gravity - ground.mean(dt);
        local.tolerated_breach = 2e-10 * size_ / dt;
        for (int b : A.members) island_of_[b] = -1;
        for (int i = 0; i < A.island_count; i++) {
            Island<d>& island = A.islands[i];
            const bool settled = !A.failed[island.bodies[0]] && settle(A, island, dt, load);
            for (int b : island.bodies) {
                island_of_[b] = i;
                if (settled) continue;
                A.failed[b] = 1;
                A.end[b] = A.start[b].at;
            }
        }
        for (int b : A.members) {
            if (island_of_[b] >= 0 || A.failed[b]) continue;
            fly(A, b, dt, load);
        }
    }

    /// A body that touches nothing; one whose turn does not settle has failed.
    void fly(Attempt& A, int b, double dt, const Vec<d>& load) {
        if (bodies[b].is_platform()) A.w[b] = A.free[b];
        else {
            double change = INFINITY, before = INFINITY;
            for (int round = 0; round < 40 && (change > FLOWN || change < before); round++) {
                A.end[b] = bodies[b].moved(0.5 * dt * A.w[b]);  // forces turn with their arms
                const Motion next = free_motion(A, b, dt, load, {});
                before = change;
                change = norm(next - A.w[b]) / std::max(norm(next), 1e-300);
                A.w[b] = next;
                if ((d == 2 && forces_on_[b].empty()) || change <= 1e-15) {
                    change = 0;
                    break;
                }
            }
            if (!(change <= FLOWN)) A.failed[b] = 1;
        }
        A.end[b] = A.failed[b] ? A.start[b].at : bodies[b].moved(0.5 * dt * A.w[b]);
    }

    /// Rows, friction and impulses of an island until none of them changes; false where they do not
    /// settle. Rows are right when their error moves no point by more than round-off of the size.
    bool settle(Attempt& A, Island<d>& island, double dt, const Vec<d>& load) {
        for (std::size_t j = 0; j < island.bodies.size(); j++) {
            const int b = island.bodies[j];
            island.mass[j] = A.mass[b];
            island.inverse_mass[j] = A.inverse_mass[b];
        }
        for (C* k : island.contacts) {
            if (k->link) set_link(A, *k, dt);
            k->mode = FrictionMode::LAW;
            k->slips = false;
            k->anchor = k->impulse;
            k->bound = bound_at_start(*k->law, k->past, k->area * dt);
        }
        const double enough = ROWS * dt / whole_;
        bool kept = false;  // impulses that nothing settled, while rows follow the motions
        for (int round = 0; round < 3 * FRICTION_ROUNDS; round++) {
            counts.outer++;
            kept |= rough_ && round == FRICTION_ROUNDS;
            for (int b : island.bodies) A.end[b] = bodies[b].moved(0.5 * dt * A.w[b]);
            for (C* k : island.contacts) write_step_rows(A, *k, dt);
            for (std::size_t j = 0; j < island.bodies.size(); j++) {
                const int b = island.bodies[j];
                const Motion touched = round ? mul(A.mass[b], A.w[b] - island.free[j]) : Motion{};
                island.free[j] = bodies[b].is_platform() ? A.free[b] : free_motion(A, b, dt, load, touched);
            }
            if (kept) {
                if (!local.keep(island)) return false;
            } else if (!local.solve(island)) {
                if (builds_up_cohesion(island)) continue;
                if (!rough_ || !local.approximate(island)) return false;
                kept = true;
            }
            if (round == 0)
                for (C* k : island.contacts) k->anchor = k->impulse;
            double off = take_motions(A, island, dt);
            if (!(off < INFINITY)) return false;
            if (off > enough) continue;
            if (!kept && !local.finish(island, at_rest(A, island))) {
                if (!rough_ || !local.take(island)) return false;
                kept = true;
                continue;
            }
            if (!kept && local.is_loose() && !local.take_back_gain(island)) return false;
            off = take_motions(A, island, dt);
            bool again = off > 100 * enough;
            if (again)
                for (C* k : island.contacts) k->anchor = k->impulse;
            for (std::size_t i = 0; i < island.contacts.size(); i++) again |= !kept && follow(*island.contacts[i], island.least[1], dt, SHARES[round / FRICTION_ROUNDS]);
            if (again) continue;
            for (int b : island.bodies) A.end[b] = bodies[b].moved(0.5 * dt * A.w[b]);
            if (rests(A, island, dt)) {
                for (int b : island.bodies) {
                    A.w[b].fill(0);
                    A.end[b] = A.start[b].at;
                }
                for (C* k : island.contacts) k->y = k->constant;
            }
            return true;
        }
        return false;
    }

    /// Takes the motions of an island; returns how far off the rows then are, of the size.
    double take_motions(Attempt& A, const Island<d>& island, double dt) const {
        double changed = 0, turned = 0;
        const double shortest = shortest_link(island);  // turns where its ends move
        for (std::size_t j = 0; j < island.bodies.size(); j++) {
            Motion& w = A.w[island.bodies[j]];
            for (int i = 0; i < unknowns; i++) {
                const double next = island.w[j][i], change = 0.5 * dt * std::fabs(next - w[i]);
                if (!std::isfinite(next)) return INFINITY;
                changed = std::max(changed, change * (i < d ? 1 : size_));
                turned = std::max(turned, 0.5 * dt * std::fabs(next) / (i < d ? shortest : 1));
            }
            w = island.w[j];
        }
        return changed * turned / size_;
    }

    /// Length of the shortest axial link of an island at the start of the step, m; infinite without any.
    double shortest_link(const Island<d>& island) const {
        double found = INFINITY;
        for (const C* k : island.contacts)
            if (k->link && k->link->link->axial) found = std::min(found, k->link->link->length[0] + k->link->link->extension[0]);
        return std::max(found, 1e-6 * size_);
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

    /// True if bodies that stand on fixed ground began at rest and go less than the tolerance leaves.
    bool rests(const Attempt& A, const Island<d>& island, double dt) const {
        return stands(island) && is_slow(island, dt) && at_rest(A, island);
    }

    /// True if all bodies of an island began without velocity.
    static bool at_rest(const Attempt& A, const Island<d>& island) {
        for (int b : island.bodies)
            if (norm(A.begun[b]) > 0) return false;
        return true;
    }

    static bool stands(const Island<d>& island) {
        for (const C* k : island.contacts)
            if (k->a < 0 || k->b < 0) return true;
        return false;
    }

    /// True if no body of an island is faster than 1e-8 of what weight does in a step.
    bool is_slow(const Island<d>& island, double dt) const {
        double fastest = 0;
        for (const Motion& w : island.w)
            for (int i = 0; i < unknowns; i++) fastest = std::max(fastest, std::fabs(w[i]) * (i < d ? 1 : size_));
        return fastest < 1e-8 * dt * norm(gravity);
    }

    /// A link begins with the force of the last step.
    static void set_link(Attempt& A, C& k, double dt) {
        A.link_steps[k.link - A.link_steps.data()].dt = dt;
        k.impulse = -dt * k.link->link->force;
    }

    void write_step_rows(const Attempt& A, C& k, double dt) const {
        if (k.link) {
            const int a = k.link->link->a, b = k.link->link->b;
            write_link_rows(k, A.start[a].at, A.end[a], A.start[b].at, A.end[b]);
            if (bodies[a].is_platform()) restrict_to_platform<d>(k.rows_b);
            if (bodies[b].is_platform()) restrict_to_platform<d>(k.rows_a);
            return;
        }
        const Vec<d> start = k.start;
        k.start = (2 / dt) * start;
        const int a = k.feature.point_body, b = k.feature.face_body;
        write_contact_rows(k, A.start[a].at, A.end[a], A.start[b].at, A.end[b]);
        k.start = start;
    }

    /// Friction by the slip that it led to; true where it changed.
    bool follow(C& k, double compliance, double dt, double share) const {
        if (k.link || k.state == OPEN) return false;
        const double way = norm_from(k.y, 1);
        double force = 0;
        for (double each : k.impulse) force = std::max(force, std::fabs(each));
        k.slips = k.state != STICK && way > SLIP_ROUND_OFF * compliance * force && way > 1e-9 * dt * norm(gravity);
        return follow_slip(*k.law, k.bound, k.slips ? 0.5 * way : 0.0, k.slips, share);
    }

    // ------------------------------------------------------------ the end of a step

    /// Takes the solved step: ledger, places, velocities, memory; then contact at velocity level.
    void finish(Attempt& A, const Piece& piece) {
        const auto& [begin, dt, ground, cuts, halves, breaks] = piece;
        counts.contacts += static_cast<long>(A.contacts.size());
        counts.most_contacts = std::max(counts.most_contacts, static_cast<long>(A.contacts.size()));
        follow_slips(A, dt);
        if (tells_pairs) follow_pairs(A, dt);
        record_landings(A, dt, begin + dt);
        for (C& k : A.contacts) close_step(A, k, dt);
        const Vec<d> acceleration = ground.mean(dt);
        for (const C& k : A.links) close_link(A, k, dt, begin + dt, piece.breaks);
        for (int b : A.members) move_body(A, b, dt, acceleration);
        for (int b : A.members) A.start[b].at = bodies[b].placement();
        if (velocity_level) {
            gather_islands(A, [](const C& k) { return k.closed; });
            for (int i = 0; i < A.island_count; i++) correct_velocities(A, A.islands[i], dt);
        }
        for (C& k : A.contacts) {
            remember(k);
            share_impulse(A, k);
        }
    }

    /// Books a contact, and notes whether it is closed and slides.
    void close_step(Attempt& A, C& k, double dt) {
        Vec<d> moved = mul(k.rows_a, A.w[k.feature.point_body]);
        if (bodies[k.feature.face_body].moves()) moved += mul(k.rows_b, A.w[k.feature.face_body]);
        double rubbed = 0;
        for (int i = 1; i < d; i++) rubbed -= 0.5 * k.impulse[i] * k.y[i];
        const double lost = -0.5 * dot(k.impulse, moved);
        ledger.friction += rubbed;
        ledger.contact += lost - rubbed;
        k.lost = lost;
        k.rubbed = rubbed;
        k.closed = k.state != OPEN || 0.5 * dt * k.y[0] < 1e-11 * size_;
        if (k.state != OPEN && k.state != STICK && !k.slips) k.state = STICK;
        k.total = k.impulse;
        k.end_gap = k.gap - k.start[0] + (k.state == OPEN ? 0.5 * dt * k.y[0] : 0.0);
        k.dt = dt;
    }

    /// Books a link; one that is stronger loaded than where it breaks, at an instant that was not found, breaks.
    void close_link(const Attempt& A, const C& k, double dt, double when, bool breaks) {
        Link<d>& link = links[k.link->link - links.data()];
        const Vec<d> reached = link.measure(A.end[link.a], A.end[link.b]);
        double work = 0;  // on the bodies
        for (int i = 0; i < link.directions(); i++) {
            work += k.impulse[i] / dt * (reached[i] - link.extension[i]);
            link.force[i] = -k.impulse[i] / dt;
            link.mean[i] -= k.impulse[i] / whole_;
        }
        ledger.damping += link.take(reached, work);
        if (breaks && link.load(link.extension) > (1 + BREAKING) * link.strength) ledger.damping += link.fracture(when);
    }

    static Vec<d> place_change(const Motion& w, double dt) {
        Vec<d> du;
        for (int i = 0; i < d; i++) du[i] = 0.5 * dt * w[i];
        return du;
    }

    void move_body(Attempt& A, int b, double dt, const Vec<d>& acceleration) {
        Body<d>& body = bodies[b];
        const Motion& w = A.w[b];
        for (int i : forces_on_[b]) {
            const Vec<d> way = place_change(w, dt) + (mul(A.end[b].R, forces[i].arm) - mul(A.start[b].at.R, forces[i].arm));
            ledger.input += dot(mean_force(A, forces[i], dt), way);
        }
        Vec<d> du = place_change(w, dt);
        if (body.is_platform()) du[d - 1] = 0;
        ledger.input -= body.mass * dot(acceleration, du);
        if (body.is_platform()) take_platform(body, du, dt);
        Vec<rotations> turn;
        for (int i = 0; i < rotations; i++) turn[i] = w[d + i];
        body.x += du;
        for (int i = 0; i < d; i++) body.v[i] = (body.is_platform() && i == d - 1) ? 0 : w[i] - body.v[i];
        if (body.is_platform()) return;
        body.rotation = body.rotation.turned(0.5 * dt * turn);
        body.turned = rotation_vector(body.rotation, body.turned);
        body.spin = to_body(A.start[b].at.R, turn) - body.spin;
    }

    /// Spring force, losses of dashpot and averaging, and the impulse on the ground of a platform.
    ///
    /// (1 - alpha_m) p_{n+1} + alpha_m p_n + k u_alpha = 0 (M6); averaging (M15) takes (1/2 - alpha_f) du dr with
    /// r = p + k u.
    void take_platform(Body<d>& body, const Vec<d>& du, double dt) {
        const double k = body.stiffness, c = body.damping;
        for (int i = 0; i + 1 < d; i++) {
            const double p = body.spring_force[i];
            const double next = -(k * (body.x[i] + (1 - scheme.alpha_f) * du[i]) + scheme.alpha_m * p) / (1 - scheme.alpha_m);
            ledger.damping += c * du[i] * du[i] / dt;
            ledger.numerical += (0.5 - scheme.alpha_f) * du[i] * (next - p + k * du[i]);
            const double late = 2 * scheme.beta;
            spring_impulse[i] += c * du[i] - dt * (late * next + (1 - late) * p);
            body.spring_force[i] = next;
        }
    }

    /// Contact at velocity level: impulses such that no contact that is closed goes on closing (M40).
    ///
    /// Contacts that slid keep the direction of their friction and stay at its bound; where a body
    /// landed all obey the law. Where that would return more energy than friction took, those that
    /// slid keep their friction, then all do, and else velocities stay as they are ((M41), (M42)).
    void correct_velocities(Attempt& A, Island<d>& island, double dt) {
        const std::size_t count = island.contacts.size();
        step_impulse_.resize(count);
        step_reading_.resize(count);
        before_.resize(count);
        state_.resize(count);
        double rubbed = 0, lost_before = 0, power = 0, quiet = 0;
        bool lands = false;
        start_instant(A, island);
        for (std::size_t i = 0; i < count; i++) {
            C& k = *island.contacts[i];
            step_impulse_[i] = k.impulse;
            step_reading_[i] = k.y;
            state_[i] = k.state;
            rubbed += k.rubbed;
            lost_before += k.lost;
            lands |= k.gap > TOUCHING * size_ && k.state != OPEN;
            island.push(k, -1.0 * k.impulse, island.free);
        }
        velocity_ = island.w;
        for (std::size_t i = 0; i < count; i++) {
            before_[i] = island.reading(*island.contacts[i]);
            power += std::fabs(dot(step_impulse_[i], before_[i]));
        }
        for (std::size_t j = 0; j < island.bodies.size(); j++) {
            island.free[j] = island.w[j] + mul(island.inverse_mass[j], island.free[j]);
            quiet += 1e-20 * bodies[island.bodies[j]].mass * dt * dt * dot(gravity, gravity);
        }
        // What the step gained beside its friction may not be given back once more.
        const double taken = std::max(std::min(rubbed, lost_before), 0.0);
        for (int rung = lands ? 0 : 1; rung < 4; rung++) {
            for (std::size_t i = 0; i < count; i++) set_rung(*island.contacts[i], step_impulse_[i], state_[i], rung);
            if (!local.solve(island) || !local.finish(island)) continue;
            double lost = 0, normal = 0;
            for (std::size_t i = 0; i < count; i++) {
                const C& k = *island.contacts[i];
                const Vec<d> y = island.reading(k);
                for (int j = 0; j < d; j++) {
                    const double work = -0.5 * (k.impulse[j] - step_impulse_[i][j]) * (before_[i][j] + y[j]);
                    lost += work;
                    if (j == 0) normal += work;
                }
            }
            if (lost + taken < -1e-13 * power - quiet) continue;
            counts.rungs[rung]++;
            const double friction = friction_share(lost - normal, lost, taken);
            ledger.friction += friction;
            ledger.contact += lost - friction;
            rest(island, dt);
            take_velocities(A, island);
            for (std::size_t i = 0; i < count; i++) {
                C& k = *island.contacts[i];
                k.velocity_impulse = k.total = k.impulse;
            }
            restore_step(island);
            return;
        }
        counts.rungs[4]++;
        restore_step(island);
    }

    void restore_step(Island<d>& island) {
        for (std::size_t i = 0; i < island.contacts.size(); i++) {
            island.contacts[i]->impulse = step_impulse_[i];
            island.contacts[i]->y = step_reading_[i];
            island.contacts[i]->state = state_[i];
        }
    }

    /// What friction of a contact is in a try: 0 all obey the law, 1 those that slid stay at their
    /// bound, 2 they keep their friction, 3 all do.
    void set_rung(C& k, const Vec<d>& step_impulse, State state, int rung) const {
        const bool slid = state == SLIP || state == SLIP_BACK;
        k.mode = FrictionMode::LAW;
        k.impulse = k.was_closed && rung < 2 ? k.velocity_impulse : step_impulse;
        k.anchor = k.impulse;
        if (rung == 3 || (rung == 2 && slid)) {
            k.mode = FrictionMode::FIXED;
            k.given = step_impulse;
        } else if (rung == 1 && slid) {
            const double size = norm_from(step_impulse, 1);
            k.mode = FrictionMode::AT_BOUND;
            k.given.fill(0);
            if (size > 0)
                for (int i = 1; i < d; i++) k.given[i] = step_impulse[i] / size;
        }
    }

    /// Rows, masses and velocities of an island at an instant.
    void start_instant(Attempt& A, Island<d>& island) {
        for (std::size_t j = 0; j < island.bodies.size(); j++) {
            const int b = island.bodies[j];
            const Body<d>& body = bodies[b];
            const Placement<d>& at = A.start[b].at;
            set_mass(b, at.R, island.mass[j], island.inverse_mass[j]);
            const auto spin = to_space(at.R, body.spin);
            for (int i = 0; i < d; i++) island.w[j][i] = body.v[i];
            for (int i = 0; i < rotations; i++) island.w[j][d + i] = spin[i];
            island.free[j].fill(0);
        }
        for (C* k : island.contacts) {
            k->start.fill(0);
            const Placement<d>&a = A.start[k->feature.point_body].at, &b = A.start[k->feature.face_body].at;
            write_contact_rows(*k, a, a, b, b);
        }
    }

    void take_velocities(Attempt& A, const Island<d>& island) {
        for (std::size_t j = 0; j < island.bodies.size(); j++) {
            const int b = island.bodies[j];
            Vec<rotations> spin;
            for (int i = 0; i < d; i++) bodies[b].v[i] = island.w[j][i];
            for (int i = 0; i < rotations; i++) spin[i] = island.w[j][d + i];
            if (!bodies[b].is_platform()) bodies[b].spin = to_body(A.start[b].at.R, spin);
        }
    }

    /// What stands on fixed ground does not drift by what the tolerance leaves: it rests.
    void rest(Island<d>& island, double dt) {
        if (!stands(island) || !is_slow(island, dt)) return;
        for (std::size_t j = 0; j < island.bodies.size(); j++) {
            ledger.contact += 0.5 * dot(island.w[j], mul(island.mass[j], island.w[j]));
            island.w[j].fill(0);
        }
    }

    void remember(const C& k) {
        const int low = std::min(k.feature.point_body, k.feature.face_body), high = std::max(k.feature.point_body, k.feature.face_body);
        Remembered<d>& record = memory_.record(low, high, k.id);
        record.impulse = k.impulse;
        record.velocity_impulse = k.velocity_impulse;
        record.closed = k.closed;
        record.gap = k.end_gap;
        record.offset.fill(0);
        record.step = number_;
        if (k.state == STICK && k.feature.kind != Kind::EDGE_EDGE && !rough_)
            for (int i = 1; i < d; i++) record.offset[i] = 0.5 * k.dt * k.y[i];
        record.friction = k.past;
        record.friction.rate = record.friction.slipped = false;
        if (k.closed && k.state != OPEN && k.slips) {
            record.friction.rate = 0.5 * norm_from(k.y, 1);
            record.friction.slipped = record.friction.broken = true;
        }
    }

    /// Adds the impulses of a contact to what its bodies got in this step.
    void share_impulse(const Attempt& A, const C& k) {
        if (!k.closed) return;
        const int a = k.feature.point_body, b = k.feature.face_body;
        Vec<d> force{};
        for (int i = 0; i < d; i++) force += k.total[i] * axis(k, i);
        if (tells_pairs) tell(A, k, force);
        if (first_part_[a] >= 0) part_received[first_part_[a] + k.feature.point_part] += force;
        if (first_part_[b] >= 0) part_received[first_part_[b] + k.feature.face_part] += -1.0 * force;
        const double up = axis(k, 0)[d - 1];
        if (bears(b, a, up)) received[a] += force;
        if (bears(a, b, -up)) received[b] += -1.0 * force;
        const double depth = -k.end_gap;
        if (!carries(a, b)) penetration[a] = std::max(penetration[a], depth);
        if (!carries(b, a)) penetration[b] = std::max(penetration[b], depth);
    }

    /// The normal of a contact, from the body of the face to that of the point, or a tangent.
    Vec<d> axis(const C& k, int number) const {
        const bool by_a = bodies[k.feature.point_body].mobility == Mobility::FREE;  // rows on a platform are cut down
        Vec<d> e;
        for (int j = 0; j < d; j++) e[j] = by_a ? k.rows_a[number][j] : -k.rows_b[number][j];
        return e;
    }

    /// True if a body stands on another one: on what carries it, or by a normal that points upwards.
    bool bears(int lower, int upper, double up) const {
        return carries(lower, upper) || (!carries(upper, lower) && up > STEEPEST);
    }

    bool carries(int lower, int upper) const {
        const std::vector<int>& below = carriers[upper];
        return std::find(below.begin(), below.end(), lower) != below.end();
    }

    /// Adds to the slip of each body the mean way of the contacts with what carries it, or that of its
    /// lowest corner.
    void follow_slips(Attempt& A, double dt) {
        ways_.resize(bodies.size());
        for (int b : A.members) ways_[b] = {};
        for (const C& k : A.contacts) {
            if (k.state == OPEN) continue;
            const int point = k.feature.point_body, face = k.feature.face_body;
            const bool upper_has_point = carries(face, point);
            if (!upper_has_point && !carries(point, face)) continue;
            const int b = upper_has_point ? point : face;
            Vec<d> moved = mul(k.rows_a, A.w[point]);
            if (bodies[face].moves()) moved += mul(k.rows_b, A.w[face]);
            Vec<d> slipped{};
            const double sign = upper_has_point ? 1 : -1;
            for (int i = 1; i < d; i++) slipped += (sign * 0.5 * dt * moved[i]) * axis(k, i);
            ways_[b].sum += transposed_mul(carrier_frame(A, b), slipped);
            ways_[b].contacts++;
        }
        for (int b : A.members) {
            if (carriers[b].empty()) continue;
            const Way& way = ways_[b];
            slip[b] += way.contacts ? (1.0 / way.contacts) * way.sum : way_in_flight(A, b, carriers[b][0]);
        }
    }

    /// Sum of the ways of some contacts of a body over what carries it, along the axes of that.
    struct Way {
        Vec<d> sum{};
        int contacts = 0;
    };

    /// Mean of the rotations at both ends of a step of the first body that carries one.
    Mat<d, d> carrier_frame(const Attempt& A, int b) const {
        const int carrier = carriers[b][0];
        return mean(A.start[carrier].at.R, A.end[carrier].R);
    }

    /// What is told of a pair, made where there is nothing; pairs stand in their order.
    PairTold<d>& told_of(int a, int b) {
        const auto [low, high] = std::minmax(a, b);
        const auto before = [](const PairTold<d>& pair, const std::pair<int, int>& key) { return std::make_pair(pair.a, pair.b) < key; };
        auto at = std::lower_bound(told.begin(), told.end(), std::make_pair(low, high), before);
        if (at == told.end() || at->a != low || at->b != high) {
            at = told.insert(at, PairTold<d>{});
            at->a = low;
            at->b = high;
        }
        return *at;
    }

    /// Adds a contact that is closed to what is told of its pair.
    void tell(const Attempt& A, const C& k, const Vec<d>& force) {
        PairTold<d>& pair = told_of(k.feature.point_body, k.feature.face_body);
        const double sign = k.feature.point_body == pair.a ? 1 : -1;
        pair.impulse += sign * force;
        Vec<d> sum = pair.points * pair.normal + (sign / norm(axis(k, 0))) * axis(k, 0);
        const double length = norm(sum);
        if (length > 0) pair.normal = (1 / length) * sum;
        pair.points++;
        const double push = std::max(k.total[0], 0.0), share = pair.pressed + push > 0 ? push / (pair.pressed + push) : 0;
        pair.place = (1 - share) * pair.place + share * place_of(A, k);
        pair.pressed += push;
    }

    /// Adds to the slip of each pair the mean way of its contacts.
    void follow_pairs(const Attempt& A, double dt) {
        std::map<std::pair<int, int>, std::tuple<Vec<d>, Vec<d>, int>> ways;
        for (const C& k : A.contacts) {
            if (k.state == OPEN) continue;
            const int a = k.feature.point_body, b = k.feature.face_body;
            const double sign = a < b ? 1 : -1;
            Vec<d> moved = mul(k.rows_a, A.w[a]);
            if (bodies[b].moves()) moved += mul(k.rows_b, A.w[b]);
            auto& [way, normal, count] = ways[std::minmax(a, b)];
            for (int i = 1; i < d; i++) way += (sign * 0.5 * dt * moved[i]) * axis(k, i);
            normal += sign * axis(k, 0);
            count++;
        }
        for (const auto& [key, found] : ways) {
            const auto& [way, normal, count] = found;
            PairTold<d>& pair = told_of(key.first, key.second);
            if (!(norm(normal) > 0)) continue;
            const auto along = tangents((1 / norm(normal)) * normal);
            for (int i = 1; i < d; i++) pair.slip[i] += dot(way, along[i - 1]) / count;
        }
    }

    /// Gaps of the pairs that are told.
    void measure_pairs() {
        std::vector<Feature<d>> none;
        for (PairTold<d>& pair : told) {
            PlacedBody<d> here, there;
            here.place(shapes, bodies[pair.a].parts, bodies[pair.a].placement());
            there.place(shapes, bodies[pair.b].parts, bodies[pair.b].placement());
            none.clear();
            // No margin cuts the search short: the axis has to be the best of all.
            pair.gap = look(pair.a, pair.b, here, there, INFINITY, none);
        }
    }

    /// Way of the lowest corner of a body over its carrier, in the carrier's frame.
    Vec<d> way_in_flight(const Attempt& A, int b, int carrier) const {
        const auto local_place = [&](const Placement<d>& own, const Placement<d>& base, const Vec<d>& corner) {
            return transposed_mul(base.R, (own.centre - base.centre) + mul(own.R, corner));
        };
        double lowest = INFINITY;
        Vec<d> way{};
        for (int number : bodies[b].parts)
            for (const Vec<d>& corner : shapes[number].vertices) {
                const Vec<d> after = local_place(A.end[b], A.end[carrier], corner);
                if (after[d - 1] >= lowest) continue;
                lowest = after[d - 1];
                way = after - local_place(A.start[b].at, A.start[carrier].at, corner);
            }
        return way;
    }

    // ------------------------------------------------------------ events inside a step

    /// Speed at which a contact comes together at the start of the step, m/s.
    double approach(const Attempt& A, const C& k) const {
        double speed = dot(k.rows_a[0], A.begun[k.feature.point_body]);
        if (bodies[k.feature.face_body].moves()) speed += dot(k.rows_b[0], A.begun[k.feature.face_body]);
        return -0.5 * speed;
    }

    bool is_new(const C& k) const { return k.gap > TOUCHING * size_; }

    /// A contact that was clear and carries an impulse, having come faster than weight moves in the step;
    /// or that touches since the end of the last step, and still comes.
    bool strikes(const Attempt& A, const C& k, double dt, double pull) const {
        return (is_new(k) || !k.was_closed) && k.state != OPEN && k.impulse[0] > 0 && approach(A, k) > 0.5 * dt * pull;
    }

    /// Slip velocities of a contact at the start and the end of the step: by the rows of the start, as
    /// those of the middle turn with a pivot, and by the mean over the step.
    std::array<Vec<d>, 2> slip_velocities(const Attempt& A, const C& k) const {
        const int a = k.feature.point_body, b = k.feature.face_body;
        C at_start = k;
        write_contact_rows(at_start, A.start[a].at, A.start[a].at, A.start[b].at, A.start[b].at);
        Vec<d> first = 0.5 * mul(at_start.rows_a, A.begun[a]), sum = mul(k.rows_a, A.w[a]);
        if (bodies[b].moves()) {
            first += 0.5 * mul(at_start.rows_b, A.begun[b]);
            sum += mul(k.rows_b, A.w[b]);
        }
        first[0] = sum[0] = 0;
        return {first, sum - first};
    }

    /// A contact whose slip turns round in the step.
    bool reverses(const Attempt& A, const C& k, double dt, double pull) const {
        if (k.state == OPEN || is_new(k)) return false;
        Vec<d> begun = mul(k.rows_a, A.begun[k.feature.point_body]);
        if (bodies[k.feature.face_body].moves()) begun += mul(k.rows_b, A.begun[k.feature.face_body]);
        if (!(0.5 * norm_from(begun, 1) > SLOW * dt * pull)) return false;
        const auto [first, last] = slip_velocities(A, k);
        return norm(first) > SLOW * dt * pull && dot(first, last) < 0;
    }

    /// Whether a link is loaded by more than its strength at the end of the step.
    bool breaks(const Attempt& A, const C& k) const {
        const Link<d>& link = *k.link->link;
        return link.load(link.measure(A.end[link.a], A.end[link.b])) > (1 + BREAKING) * link.strength;
    }

    bool any_breaks(const Attempt& A) const {
        return std::any_of(A.links.begin(), A.links.end(), [&](const C& k) { return breaks(A, k); });
    }

    bool something_happens(const Attempt& A, double dt, double pull) const {
        for (const C& k : A.contacts) {
            if (A.failed[k.feature.point_body] || A.failed[k.feature.face_body]) continue;
            if (strikes(A, k, dt, pull) || reverses(A, k, dt, pull)) return true;
        }
        return false;
    }

    /// True if a group is stepped to the instant at which something happens. For many bodies that is
    /// dear, and for plastic impacts of first order without.
    bool is_cut(const Attempt& A, const Piece& piece, double pull) const {
        if (static_cast<int>(A.members.size()) <= LARGEST_CUT || (piece.breaks && any_breaks(A))) return true;
        for (const C& k : A.contacts)
            if (k.law->restitution > 0 && strikes(A, k, piece.dt, pull)) return true;
        return false;
    }

    /// Bodies near each other, however fast they left.
    std::vector<std::vector<int>> groups_of(Attempt& A) {
        for (int b : A.members) root_[b] = b;
        wide_ = A.margin;
        for (int b : A.members) wide_[b] = 2 * std::max(A.margin[b], A.way[b]);
        for (const C& k : A.contacts) join(k);
        for (const C& k : A.links) join(k);
        for (const auto& [a, b] : broad_.find(A.listed, bodies, A.start, wide_))
            if (bodies[a].moves() && bodies[b].moves()) root_[top(a)] = top(b);
        std::vector<std::vector<int>> groups;
        std::vector<int> number(bodies.size(), -1);
        for (int b : A.members) {
            int& at = number[top(b)];
            if (at < 0) {
                at = static_cast<int>(groups.size());
                groups.emplace_back();
            }
            groups[at].push_back(b);
        }
        return groups;
    }

    /// Finishes the groups in which nothing happens, and steps the others one by one.
    bool by_groups(Attempt& A, int depth, const std::vector<std::vector<int>>& groups, const Piece& piece, double pull) {
        std::vector<int> group_of(bodies.size(), -1);
        std::vector<char> again(groups.size(), 0);
        for (std::size_t g = 0; g < groups.size(); g++)
            for (int b : groups[g]) {
                group_of[b] = static_cast<int>(g);
                again[g] |= A.failed[b];
            }
        const auto group = [&](const C& k) { return group_of[bodies[k.feature.point_body].moves() ? k.feature.point_body : k.feature.face_body]; };
        if (piece.cuts > 0)
            for (const C& k : A.contacts)
                if (strikes(A, k, piece.dt, pull) || reverses(A, k, piece.dt, pull)) again[group(k)] = 1;
        if (piece.cuts > 0 && piece.breaks)
            for (const C& k : A.links)
                if (breaks(A, k)) again[group(k)] = 1;
        std::vector<int> quiet;
        for (std::size_t g = 0; g < groups.size(); g++)
            if (!again[g]) quiet.insert(quiet.end(), groups[g].begin(), groups[g].end());
        for (std::vector<C>* list : {&A.contacts, &A.links})
            list->erase(std::remove_if(list->begin(), list->end(), [&](const C& k) { return again[group(k)] != 0; }), list->end());
        A.members = quiet;
        finish(A, piece);
        for (std::size_t g = 0; g < groups.size(); g++)
            if (again[g] && !advance(depth + 1, groups[g], piece)) return false;
        return true;
    }

    /// Two steps of half the length; the shortest one is taken at the accuracy that there is, and what
    /// follows it in the step sooner than that.
    bool by_halves(Attempt& A, int depth, const Piece& piece) {
        const std::vector<int> members = A.members;
        if (0.5 * piece.dt >= smallest_ && (piece.halves || piece.dt > whole_ / MOST_ROUGH)) {
            counts.halved++;
            const long before = counts.unsettled;
            if (!advance(depth + 1, members, piece.first(0.5 * piece.dt))) return false;
            Piece rest = piece.rest(0.5 * piece.dt);
            rest.halves = counts.unsettled == before;
            return advance(depth + 1, members, rest);
        }
        if (rough_) return false;
        counts.unsettled++;
        rough_ = true;
        const bool taken = advance(depth + 1, members, {piece.begin, piece.dt, piece.ground, 0, true, piece.breaks});
        rough_ = false;
        return taken;
    }

    /// Steps one group to the first touch or end of slip in it, and on from there.
    bool in_pieces(Attempt& A, int depth, const Piece& piece, double pull) {
        const std::vector<int> members = A.members;
        if (piece.breaks && any_breaks(A)) return to_fracture(A, depth, piece);
        bool touches = false;
        for (const C& k : A.contacts) touches |= strikes(A, k, piece.dt, pull);
        bool at_start = false;
        for (const C& k : A.contacts) at_start |= !is_new(k) && strikes(A, k, piece.dt, pull);
        double length = 0.5 * AT_END * piece.dt;
        if (!touches) length = locate_end_of_slip(A, piece.dt, piece.ground, pull);
        else if (!at_start) length = locate_touch(A, piece.dt, piece.ground);
        // Where no instant was found inside the step: all of it at once.
        if (!(length > 0)) return advance(depth + 1, members, {piece.begin, piece.dt, piece.ground, 0, true, piece.breaks});
        counts.cut++;
        const bool at_once = length < AT_END * piece.dt;
        if (!at_once) finish(A, piece.first(length));
        Piece rest = at_once ? piece : piece.rest(length);
        rest.cuts--;
        if (touches) collide(depth + 1, members, rest.begin);
        return length == piece.dt || advance(depth + 1, members, rest);
    }

    /// Steps one group to the instant at which a link breaks, and on from there.
    bool to_fracture(Attempt& A, int depth, const Piece& piece) {
        const std::vector<int> members = A.members;
        std::vector<int> breaking;
        for (const C& k : A.links)
            if (breaks(A, k)) breaking.push_back(static_cast<int>(k.link->link - links.data()));
        const double length = locate_fracture(A, piece.dt, piece.ground, breaking);
        counts.cut++;
        if (length > AT_END * piece.dt) {
            Piece before = piece.first(length);
            before.breaks = false;
            if (!advance(depth + 1, members, before)) return false;
        }
        for (int i : breaking)
            if (links[i].load(links[i].extension) >= (1 - FRACTURE) * links[i].strength) ledger.damping += links[i].fracture(piece.begin + length);
        Piece rest = piece.rest(std::max(length, 0.0));
        rest.cuts--;
        return !(rest.dt > AT_END * piece.dt) || advance(depth + 1, members, rest);
    }

    /// Length of the step at whose end the first of some links breaks; 0 where it does at once.
    double locate_fracture(Attempt& A, double dt, const GroundMotion<d>& ground, const std::vector<int>& breaking) {
        std::vector<Bracket> brackets(breaking.size());
        for (std::size_t i = 0; i < breaking.size(); i++) {
            const Link<d>& link = links[breaking[i]];
            brackets[i].at_low = link.strength - link.load(link.extension);
            if (!(brackets[i].at_low > 0)) return 0;
        }
        double length = dt;
        for (int round = 0; round < LOCATING; round++) {
            double least = INFINITY, next = INFINITY;
            for (std::size_t i = 0; i < breaking.size(); i++) {
                const Link<d>& link = links[breaking[i]];
                const double left = link.strength - link.load(link.measure(A.end[link.a], A.end[link.b]));
                brackets[i].narrow(length, left);
                least = std::min(least, left / link.strength);
                next = std::min(next, brackets[i].root());
            }
            if (std::fabs(least) <= BREAKING || !(next < dt)) break;
            length = next;
            if (!solve_length(A, length, ground)) break;
        }
        return length;
    }

    /// Regula falsi (Illinois) for a value that falls from positive to negative.
    struct Bracket {
        double low = 0, at_low, high = INFINITY, at_high = 0;
        int side = 0;
        void narrow(double length, double value) {
            const int now = value > 0 ? 1 : -1;
            if (now > 0) {
                low = length;
                at_low = value;
                if (side == now) at_high *= 0.5;
            } else {
                high = length;
                at_high = value;
                if (side == now) at_low *= 0.5;
            }
            side = now;
        }
        /// The next length to try; infinite where the value has not been negative.
        double root() const { return high < INFINITY ? low + (high - low) * at_low / (at_low - at_high) : INFINITY; }
    };

    /// Solves the step of another length with some contacts; false where that failed.
    bool solve_length(Attempt& A, double length, const GroundMotion<d>& ground) {
        for (int b : A.members) {
            A.failed[b] = 0;
            A.w[b] = A.begun[b];
            if (bodies[b].is_platform()) set_platform(A, b, length, ground);
        }
        gather_islands(A);
        settle_all(A, length, ground);
        for (int b : A.members)
            if (A.failed[b]) return false;
        return true;
    }

    /// Length of the step at whose end the first contact touches; it is then solved without those that
    /// were clear. 0 where there is none.
    double locate_touch(Attempt& A, double dt, const GroundMotion<d>& ground) {
        std::vector<C> clear, touching;
        std::vector<Bracket> brackets;
        for (const C& k : A.contacts) (is_new(k) ? clear : touching).push_back(k);
        A.contacts.swap(touching);
        for (const C& k : clear) {
            brackets.emplace_back();
            brackets.back().at_low = k.gap;
        }
        double length = dt;
        bool found = false;
        for (int round = 0; round < LOCATING && !found; round++) {
            if (!solve_length(A, length, ground)) return 0;
            double least = INFINITY, next = INFINITY;
            for (std::size_t i = 0; i < clear.size(); i++) {
                const Feature<d>& feature = clear[i].feature;
                const double gap = gap_between(feature, A.end[feature.point_body], A.end[feature.face_body]);
                brackets[i].narrow(length, gap);
                least = std::min(least, gap);
                next = std::min(next, brackets[i].root());
            }
            found = std::fabs(least) <= ROUND_OFF * size_;
            if (found) break;
            if (!(next < INFINITY)) return 0;
            length = next;
        }
        if (!found) return 0;
        if (length < (1 - AT_END) * dt) return length;
        return solve_length(A, dt, ground) ? dt : 0;
    }

    /// Length of the step at whose end the first slip stops; it is then solved. 0 where there is none.
    double locate_end_of_slip(Attempt& A, double dt, const GroundMotion<d>& ground, double pull) {
        const C* first = nullptr;
        double soonest = INFINITY;
        for (const C& k : A.contacts) {
            if (!reverses(A, k, dt, pull)) continue;
            const auto [begin, end] = slip_velocities(A, k);
            const double when = dot(begin, begin) / (dot(begin, begin) - dot(begin, end));
            if (when < soonest) {
                soonest = when;
                first = &k;
            }
        }
        if (!first) return 0;
        Bracket bracket;
        double length = dt;
        for (int round = 0; round < LOCATING; round++) {
            const auto [begin, end] = slip_velocities(A, *first);
            const double speed = norm(begin), left = dot(begin, end) / speed;
            if (round == 0) bracket.at_low = speed;
            if (std::fabs(left) <= STOPPED * speed) return length > SMALLEST_PIECE * dt && length < (1 - SMALLEST_PIECE) * dt ? length : 0;
            bracket.narrow(length, left);
            length = bracket.root();
            if (length < SMALLEST_PIECE * dt || !solve_length(A, length, ground)) return 0;
        }
        return 0;
    }

    // ------------------------------------------------------------ impacts

    /// Gives the velocities a jump where contacts that touch come together, and books it.
    void collide(int depth, const std::vector<int>& members, double when) {
        Attempt& A = attempt(depth);
        A.members = members;
        for (int b : members) A.least[b] = 0;
        const GroundMotion<d> none{};
        set_out(A, 0, none);
        find_contacts(A, 0, none);
        for (C& k : A.contacts) {
            const int a = k.feature.point_body, b = k.feature.face_body;
            write_contact_rows(k, A.start[a].at, A.start[a].at, A.start[b].at, A.start[b].at);
            k.closed = k.gap <= LANDING * size_;
            k.end_gap = k.gap;
        }
        gather_islands(A, [](const C& k) { return k.closed; });
        for (int i = 0; i < A.island_count; i++) strike(A, A.islands[i], when);
        for (C& k : A.contacts)
            if (k.closed) {
                remember_impact(k);
                share_impulse(A, k);
            }
    }

    /// Notes that a contact struck, and how fast it slips afterwards.
    void remember_impact(const C& k) {
        if (!(k.impulse[0] > 0)) return;
        const auto [low, high] = std::minmax(k.feature.point_body, k.feature.face_body);
        Remembered<d>& record = memory_.record(low, high, k.id);
        const double rate = k.state == SLIP || k.state == SLIP_BACK ? norm_from(k.y, 1) : 0.0;
        const bool broken = record.friction.broken || rate > 0;
        record = {k.id, {}, {}, {}, k.gap, true, {rate, rate > 0, broken}, number_};
    }

    /// The law of impact on the touching contacts of an island, at an instant:
    ///
    ///     0 <= P_n  complementary to  v_n+ - r >= 0,     r = e [-v_n-(2 c - x)]_+,            (M48)
    ///
    /// x being the place of the contact and c the middle of the two contacts of its pair that are
    /// farthest apart: a contact takes the rebound of the place opposite. A block that stands on one
    /// edge and lands on the opposite one leaves the first with e times the speed of the landing, as in
    /// Housner's equation; one that lands flat rebounds with e times its speed, as in Newton's law. What
    /// lands alone has no rebound, nor has in space an edge. Below Housner's e the old pivots have to
    /// be held back: there alone an impulse may pull.
    void strike(Attempt& A, Island<d>& island, double when) {
        start_instant(A, island);
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
        if (!approaching || !settle_impact(island)) return;
        if (rebounding) rebound(A, island);
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
        const double friction = std::min(std::max(lost - normal, 0.0), std::max(lost, 0.0));
        ledger.friction += friction;
        ledger.contact += lost - friction;
        take_velocities(A, island);
        record_impacts(A, island, when);
    }

    /// Impulses of an impact from none, with the friction of the slip that they leave.
    bool settle_impact(Island<d>& island) {
        for (C* k : island.contacts) {
            k->impulse.fill(0);
            k->anchor.fill(0);
        }
        for (double share : SHARES)
            for (int round = 0; round < FRICTION_ROUNDS; round++) {
                if (!local.solve(island)) return false;
                bool changed = false;
                for (std::size_t i = 0; i < island.contacts.size(); i++) {
                    C& k = *island.contacts[i];
                    const bool slips = k.state == SLIP || k.state == SLIP_BACK;
                    const double speed = 0.5 * norm_from(before_[i] + island.reading(k), 1);
                    if (k.mode == FrictionMode::LAW && k.bound.mu > 0) changed |= follow_slip(*k.law, k.bound, slips ? speed : 0.0, slips, share);
                }
                if (!changed) return local.finish(island);
            }
        return false;
    }

    /// Replaces the impulses of a plastic impact by those with rebounds, as far as these gain no energy.
    void rebound(Attempt& A, Island<d>& island) {
        const std::size_t count = island.contacts.size();
        std::vector<Vec<d>> plastic(count);
        std::vector<double> speed(count, 0), pull(count, 0);
        std::vector<char> pivot(count, 0);
        for (std::size_t i = 0; i < count; i++) plastic[i] = island.contacts[i]->impulse;
        if (!find_rebounds(A, island, speed, pivot)) return;
        for (std::size_t i = 0; i < count; i++) island.contacts[i]->constant[0] = -speed[i];
        if (!settle_impact(island)) {
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
        std::vector<Vec<d>> found(count);
        for (std::size_t i = 0; i < count; i++) found[i] = island.contacts[i]->impulse;
        for (int round = 0; pulls && round < 8; round++) {
            island.free = velocity_;
            for (std::size_t i = 0; i < count; i++) {
                Vec<d> held{};
                held[0] = -pull[i];
                pushed_.assign(island.w.size(), {});
                island.push(*island.contacts[i], held, pushed_);
                for (std::size_t j = 0; j < island.w.size(); j++) island.free[j] += mul(island.inverse_mass[j], pushed_[j]);
            }
            bool enough = settle_impact(island);
            for (std::size_t i = 0; i < count && enough; i++) enough = pull[i] == 0 || island.contacts[i]->impulse[0] > 0.5 * pull[i];
            if (enough) {
                for (std::size_t i = 0; i < count; i++) {
                    found[i] = island.contacts[i]->impulse;
                    found[i][0] -= pull[i];
                }
                break;
            }
            for (double& each : pull) each *= 10;
        }
        island.free = velocity_;
        take_without_gain(island, plastic, found);
    }

    /// Impulses on the way from those of the plastic impact as far as no energy is gained: what is lost
    /// on the way is a parabola.
    void take_without_gain(Island<d>& island, const std::vector<Vec<d>>& plastic, const std::vector<Vec<d>>& found) {
        const std::size_t count = island.contacts.size();
        const auto motion_of = [&](auto impulse) {
            std::vector<Motion> moved(island.w.size(), Motion{});
            for (std::size_t i = 0; i < count; i++) island.push(*island.contacts[i], impulse(i), moved);
            for (std::size_t j = 0; j < moved.size(); j++) moved[j] = mul(island.inverse_mass[j], moved[j]);
            return moved;
        };
        const auto first = motion_of([&](std::size_t i) { return plastic[i]; });
        const auto way = motion_of([&](std::size_t i) { return found[i] - plastic[i]; });
        double lost = 0, slope = 0, curve = 0, power = 0;
        for (std::size_t j = 0; j < way.size(); j++) {
            const Motion pushed = mul(island.mass[j], first[j]), along = mul(island.mass[j], way[j]);
            lost -= dot(pushed, velocity_[j]) + 0.5 * dot(pushed, first[j]);
            slope -= dot(along, velocity_[j]) + dot(along, first[j]);
            curve += 0.5 * dot(along, way[j]);
        }
        for (std::size_t i = 0; i < count; i++) power += std::fabs(dot(found[i], before_[i]));
        double part = 1;
        if (lost + slope - curve < -1e-14 * power) part = std::clamp((slope + std::sqrt(slope * slope + 4 * curve * std::max(lost, 0.0))) / (2 * curve), 0.0, 1.0);
        for (std::size_t i = 0; i < count; i++) island.contacts[i]->impulse = plastic[i] + part * (found[i] - plastic[i]);
    }

    Vec<d> place_of(const Attempt& A, const C& k) const {
        const Placement<d>& a = A.start[k.feature.point_body].at;
        if constexpr (d == 3)
            if (k.feature.kind == Kind::EDGE_EDGE) {
                const Shape<3>&own = point_shape(k.feature), &other = face_shape(k.feature);
                const Placement<3>& b = A.start[k.feature.face_body].at;
                const Edge &x = own.edges[k.feature.point], &y = other.edges[k.feature.face];
                const Vec<3> P = a.centre + mul(a.R, own.vertices[x.from]), u = mul(a.R, own.vertices[x.to] - own.vertices[x.from]);
                const Vec<3> Q = b.centre + mul(b.R, other.vertices[y.from]), v = mul(b.R, other.vertices[y.to] - other.vertices[y.from]);
                return P + crossing(P, u, Q, v, k.feature.sign).s * u;
            }
        return a.centre + mul(a.R, k.feature.arm);
    }

    /// The rebound of each contact, and which of them are pivots of a block that lands; false where
    /// there is no rebound.
    bool find_rebounds(const Attempt& A, const Island<d>& island, std::vector<double>& speed, std::vector<char>& pivot) const {
        const std::size_t count = island.contacts.size();
        std::vector<Vec<d>> place(count);
        for (std::size_t i = 0; i < count; i++) place[i] = place_of(A, *island.contacts[i]);
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

    /// Gradient of the normal velocity of a contact over its place, 1/s: n x omega of the relative spin.
    Vec<d> gradient(const C& k) const {
        Vec<rotations> spin{};
        for (int i = 0; i < rotations; i++) {
            if (k.a >= 0) spin[i] += velocity_[k.a][d + i];
            if (k.b >= 0) spin[i] -= velocity_[k.b][d + i];
        }
        const Vec<d> n = axis(k, 0);
        if constexpr (d == 2) return {spin[0] * n[1], -spin[0] * n[0]};
        else return cross(n, spin);
    }

    /// Notes the bodies that met at an instant, by the impulses and velocities of their points.
    void record_impacts(const Attempt& A, const Island<d>& island, double when) {
        const std::size_t first = collisions.size();
        const auto spin = [](const std::vector<Motion>& of, const C& k) {
            Vec<rotations> turn{};
            for (int i = 0; i < rotations; i++) turn[i] = (k.a >= 0 ? of[k.a][d + i] : 0) - (k.b >= 0 ? of[k.b][d + i] : 0);
            return turn;
        };
        for (std::size_t i = 0; i < island.contacts.size(); i++) {
            const C& k = *island.contacts[i];
            if (k.was_closed) continue;
            const double own = k.a >= 0 ? -dot(k.rows_a[0], velocity_[k.a]) : 0;
            record_impact(A, k, first, when, k.impulse, before_[i], island.reading(k), own, spin(velocity_, k), spin(island.w, k));
        }
        // What the impact does where the two touched before belongs to it.
        for (std::size_t i = 0; i < island.contacts.size(); i++) {
            const C& k = *island.contacts[i];
            if (!k.was_closed) continue;
            if (Collision<d>* met = collision_of(k, first)) add_impulse(*met, k, k.impulse, before_[i] + island.reading(k));
        }
    }

    /// The collision of the pair of a contact, from a first one on; none: nullptr.
    Collision<d>* collision_of(const C& k, std::size_t first) {
        const auto [a, b] = std::minmax(k.feature.point_body, k.feature.face_body);
        for (std::size_t i = first; i < collisions.size(); i++)
            if (collisions[i].a == a && collisions[i].b == b) return &collisions[i];
        return nullptr;
    }

    void add_impulse(Collision<d>& met, const C& k, const Vec<d>& impulse, const Vec<d>& speeds) const {
        const double sign = k.feature.point_body == met.a ? 1 : -1;
        for (int i = 0; i < d; i++) met.impulse += (sign * impulse[i]) * axis(k, i);
        met.energy -= 0.5 * dot(impulse, speeds);
    }

    /// Adds a point that came together to the collision of its pair, from a first one on. `own`: what
    /// the body of the point brings to its approach; spins: of that body against the other.
    void record_impact(const Attempt& A, const C& k, std::size_t first, double when, const Vec<d>& impulse, const Vec<d>& before,
                       const Vec<d>& after, double own, const Vec<rotations>& spin, const Vec<rotations>& later_spin) {
        if (!(impulse[0] > 0) || !(before[0] < 0)) return;
        if (!collision_of(k, first)) {
            collisions.emplace_back();
            collisions.back().time = when;
            collisions.back().a = std::min(k.feature.point_body, k.feature.face_body);
            collisions.back().b = std::max(k.feature.point_body, k.feature.face_body);
        }
        Collision<d>& met = *collision_of(k, first);
        const double sign = k.feature.point_body == met.a ? 1 : -1, old = sign * dot(met.impulse, met.normal);
        const double share = impulse[0] / (impulse[0] + std::fabs(old));
        met.points++;
        met.place = (1 - share) * met.place + share * place_of(A, k);
        met.normal = (1 - share) * met.normal + (share * sign) * axis(k, 0);
        if (-before[0] > met.approach) met.brought = sign > 0 ? own : -before[0] - own;
        met.approach = std::max(met.approach, -before[0]);
        met.departure = std::max(met.departure, after[0]);
        met.spin = sign * spin;
        met.later_spin = sign * later_spin;
        add_impulse(met, k, impulse, before + after);
    }

    /// Notes the contacts that closed in a step which was not cut there.
    void record_landings(const Attempt& A, double dt, double when) {
        const std::size_t first = collisions.size();
        for (const C& k : A.contacts) {
            if ((!is_new(k) && k.was_closed) || k.state == OPEN || !(k.impulse[0] > 0)) continue;
            const double pull = norm(gravity), speed = approach(A, k);
            if (!(speed > 0.5 * dt * pull)) continue;
            Vec<d> before{};
            before[0] = -speed;
            const int a = k.feature.point_body, b = k.feature.face_body;
            Vec<rotations> spin, later;
            later.fill(NAN);  // not before the velocity level
            for (int i = 0; i < rotations; i++) spin[i] = 0.5 * (A.begun[a][d + i] - (bodies[b].moves() ? A.begun[b][d + i] : 0));
            const double own = -0.5 * dot(k.rows_a[0], A.begun[a]);
            record_impact(A, k, first, when, k.impulse, before, {}, own, spin, later);
        }
    }

    double size_ = 1, smallest_ = 0, whole_ = 0;  // m, s, s
    long number_ = 0;
    ContactMemory<d> memory_;
    BroadPhase<d> broad_;
    std::deque<Attempt> attempts_;
    std::vector<int> moving_, fixed_, root_, local_, island_of_;
    std::vector<std::vector<int>> forces_on_;  // of each body
    std::vector<int> first_part_;  // of each body among those of all; -1: it has one
    std::vector<char> is_member_;
    std::vector<double> wide_;
    std::vector<Way> ways_;
    std::vector<Vec<d>> step_impulse_, step_reading_, before_;
    std::vector<State> state_;
    std::vector<Motion> velocity_, pushed_;
    bool rough_ = false;  // what is not solved is taken as it is
};

}  // namespace rockslip
