// Islands: bodies joined by contacts, with their equations of motion for a step or an instant.
#pragma once

#include <vector>

#include "block_lu.hpp"
#include "contact.hpp"

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
    std::vector<Pair> length, own;           // r, and the diagonal of W = G M^-1 G^T
    Pair least{};                            // of own: what moves the heaviest bodies
    std::vector<int> factored;               // states of the factors at hand
    double factored_softness = -1;
    long factored_stamp = 0;

    void clear() {
        bodies.clear();
        contacts.clear();
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

}  // namespace rockslip
