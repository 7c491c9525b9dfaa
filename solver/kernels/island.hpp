// Islands: bodies joined by contacts and links, with their equations of motion for a step or an instant.
#pragma once

#include <initializer_list>
#include <vector>

#include "block_lu.hpp"
#include "contact.hpp"
#include "disjoint_sets.hpp"

namespace rockslip {

/// Bodies joined by contacts, and their equations of motion for a step or an instant.
template <int d> struct Island {
    static constexpr int unknowns = Dim<d>::unknowns;
    using Motion = Vec<unknowns>;
    using Pair = std::array<double, 2>;  // normal, tangential

    std::vector<int> bodies;                 // numbers in the world
    std::vector<Contact<d>*> contacts;
    std::vector<Mat<unknowns, unknowns>> mass, inverse_mass;
    std::vector<Motion> free, w;             // motion without contacts, and with them
    std::vector<Pair> own, share;            // the diagonal of W = G M^-1 G^T, and what it is of the row sums of |W|
    Pair least{};                            // of own: what moves the heaviest bodies
    std::vector<int> factored;               // states of the factors at hand
    double factored_softness = -1;
    long factored_stamp = 0;

    void clear() {
        bodies.clear();
        contacts.clear();
    }

    /// Makes room for the motions of all bodies.
    void make_room() {
        mass.resize(bodies.size());
        inverse_mass.resize(bodies.size());
        free.resize(bodies.size());
        w.resize(bodies.size());
    }

    /// True if it stands on fixed ground, and no body is faster than a velocity; rotations count by a length.
    bool rests(double velocity, double size) const {
        const auto is_fixed = [](const Contact<d>* k) { return k->a < 0 || k->b < 0; };
        if (!std::any_of(contacts.begin(), contacts.end(), is_fixed)) return false;
        double fastest = 0;
        for (const Motion& each : w)
            for (int i = 0; i < unknowns; i++) fastest = std::max(fastest, std::fabs(each[i]) * (i < d ? 1 : size));
        return fastest < velocity;
    }

    /// Sets the motions to those by the impulses: w = w_free + M^-1 G^T P.
    void move() {
        for (Motion& each : w) each.fill(0);
        for (const Contact<d>* k : contacts) push(*k, k->impulse, w);
        for (std::size_t b = 0; b < w.size(); b++) w[b] = free[b] + mul(inverse_mass[b], w[b]);
    }

    /// Adds G^T P of a contact.
    static void push(const Contact<d>& k, const Vec<d>& P, std::vector<Motion>& x) {
        if (k.a >= 0) x[k.a] += transposed_mul(k.rows_a, P);
        if (k.b >= 0) x[k.b] += transposed_mul(k.rows_b, P);
    }

    /// G x of a contact.
    static Vec<d> moved(const Contact<d>& k, const std::vector<Motion>& x) {
        Vec<d> y{};
        if (k.a >= 0) y += mul(k.rows_a, x[k.a]);
        if (k.b >= 0) y += mul(k.rows_b, x[k.b]);
        return y;
    }

    /// y of a contact.
    Vec<d> reading(const Contact<d>& k) const { return k.constant + moved(k, w); }

    /// M + G^T H G, H by contacts (M58).
    void assemble(const std::vector<Mat<d, d>>& H, BlockLU<unknowns>& factors) const {
        factors.clear();
        for (std::size_t b = 0; b < w.size(); b++) factors.diagonal(static_cast<int>(b)) = mass[b];
        for (std::size_t i = 0; i < contacts.size(); i++) {
            const Contact<d>& k = *contacts[i];
            Mat<d, unknowns> of_a{}, of_b{};
            add_product(of_a, H[i], k.rows_a, 1);
            add_product(of_b, H[i], k.rows_b, 1);
            if (k.a >= 0) add_transposed_product(factors.diagonal(k.a), k.rows_a, of_a);
            if (k.b >= 0) add_transposed_product(factors.diagonal(k.b), k.rows_b, of_b);
            if (k.a >= 0 && k.b >= 0) {
                add_transposed_product(factors.off_diagonal(k.a, k.b), k.rows_a, of_b);
                add_transposed_product(factors.off_diagonal(k.b, k.a), k.rows_b, of_a);
            }
        }
    }
};

/// The islands of some bodies.
template <int d> class Islands {
  public:
    /// Gathers bodies joined by those contacts of some lists that `count`; contacts keep their places as long.
    template <class Counts>
    void gather(const std::vector<Body<d>>& bodies, const std::vector<int>& members,
                std::initializer_list<std::vector<Contact<d>>*> lists, Counts count) {
        sets_.part(members, bodies.size());
        number_in_.resize(bodies.size());
        island_of_.resize(bodies.size());
        for (int b : members) number_in_[b] = island_of_[b] = -1;
        for (const auto* contacts : lists)
            for (const Contact<d>& k : *contacts) {
                const int a = k.feature.point_body, b = k.feature.face_body;
                if (count(k) && bodies[a].moves() && bodies[b].moves()) sets_.join(a, b);
            }
        count_ = 0;
        for (auto* contacts : lists)
            for (Contact<d>& k : *contacts)
                if (count(k)) take(bodies, k);
        for (Island<d>& island : *this) island.make_room();
    }

    auto begin() { return all_.begin(); }
    auto end() { return all_.begin() + count_; }

    /// Whether a contact or a link holds a body in an island.
    bool holds(int body) const { return number_in_[body] >= 0; }

  private:
    void take(const std::vector<Body<d>>& bodies, Contact<d>& k) {
        const int a = k.feature.point_body, b = k.feature.face_body, top = sets_.top(bodies[a].moves() ? a : b);
        if (island_of_[top] < 0) {
            island_of_[top] = count_++;
            if (static_cast<int>(all_.size()) < count_) all_.emplace_back();
            all_[island_of_[top]].clear();
        }
        Island<d>& island = all_[island_of_[top]];
        for (int body : {a, b})
            if (bodies[body].moves() && number_in_[body] < 0) {
                number_in_[body] = static_cast<int>(island.bodies.size());
                island.bodies.push_back(body);
            }
        k.a = bodies[a].moves() ? number_in_[a] : -1;
        k.b = bodies[b].moves() ? number_in_[b] : -1;
        island.contacts.push_back(&k);
    }

    DisjointSets sets_;
    std::vector<int> number_in_, island_of_;  // number of a body in its island; island of the top of its set
    std::vector<Island<d>> all_;
    int count_ = 0;
};

}  // namespace rockslip
