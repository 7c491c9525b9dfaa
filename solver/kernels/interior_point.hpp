// Coulomb's law from nothing, by a primal-dual interior point method.
//
// With y_t scaled by mu and s = mu |y_t| the law of an island reads (de Saxce and Feng 1998)
//
//     x = (P_n, P_t / mu),   z = (y_n + s, mu y_t),   |x_t| <= x_n, |z_t| <= z_n, x.z = 0.       (M59)
//
// The products of x and z go to zero together, with the scaling of Nesterov and Todd (1997) and the
// predictor and corrector of Mehrotra (1992). It needs some 15 factorizations of a matrix
// as sparse as that of Newton's method, knows no states to cycle through, and is not sharp at the end.
#pragma once

#include "island.hpp"

namespace rockslip {

/// The cone |v_t| <= v_n, and its algebra (Alizadeh and Goldfarb 2003).
template <int d> struct Cone {
    using V = Vec<d>;

    static double determinant(const V& v) {
        const double size = norm_from(v, 1);
        return (v[0] - size) * (v[0] + size);
    }

    static V product(const V& a, const V& b) {
        V c;
        c[0] = dot(a, b);
        for (int i = 1; i < d; i++) c[i] = a[0] * b[i] + b[0] * a[i];
        return c;
    }

    /// c with product(a, c) = b.
    static V quotient(const V& a, const V& b) {
        V c;
        c[0] = inner(a, b) / determinant(a);
        for (int i = 1; i < d; i++) c[i] = (b[i] - c[0] * a[i]) / a[0];
        return c;
    }

    /// How many times a change can be added to v before it leaves the cone.
    static double longest(const V& v, const V& change) {
        const double a = determinant(change), b = inner(v, change), c = determinant(v);
        const double root = std::sqrt(std::max(b * b - a * c, 0.0)), sum = -b - std::copysign(root, b);
        double most = change[0] < 0 ? -v[0] / change[0] : INFINITY;
        for (const double each : {sum / a, c / sum})
            if (b * b >= a * c && each > 0) most = std::min(most, each);
        return most;
    }

    /// W of Nesterov and Todd, W x = W^-1 z.
    struct Scaling {
        V u{};
        double size = 1;

        Scaling() = default;
        Scaling(const V& x, const V& z) {
            const double of_x = std::sqrt(determinant(x)), of_z = std::sqrt(determinant(z));
            for (int i = 0; i < d; i++) u[i] = z[i] / of_z + (i ? -1 : 1) * x[i] / of_x;
            u = (1 / std::sqrt(2 * (1 + (dot(x, z) / (of_x * of_z))))) * u;
            u[0] += 1;
            u = (1 / std::sqrt(2 * u[0])) * u;
            size = std::sqrt(of_z / of_x);
        }

        V times(const V& v) const { return apply(v, 1, size); }
        V inverse_times(const V& v) const { return apply(v, -1, 1 / size); }

      private:
        V apply(const V& v, double sign, double factor) const {
            V r = u;
            for (int i = 1; i < d; i++) r[i] *= sign;
            const double twice = 2 * dot(r, v);
            V result;
            for (int i = 0; i < d; i++) result[i] = factor * (twice * r[i] + (i ? v[i] : -v[i]));
            return result;
        }
    };

  private:
    static double inner(const V& a, const V& b) {
        double sum = a[0] * b[0];
        for (int i = 1; i < d; i++) sum -= a[i] * b[i];
        return sum;
    }
};

template <int d> class InteriorPoint {
    static constexpr int unknowns = Dim<d>::unknowns;
    using V = Vec<d>;
    using K = Cone<d>;

  public:
    /// Writes impulses near those of the law, and the motions that they lead to; false where they are
    /// not found, friction is given, or there are links. Cohesion is a mu that follows P_n.
    bool solve(Island<d>& island, BlockLU<unknowns>& factors) {
        island.factored_stamp = -1;
        if (!begin(island)) return false;
        double first = 0;
        for (int round = 0; round < ROUNDS; round++) {
            double product = 0, missing = 0;
            for (std::size_t i = 0; i < points_.size(); i++) {
                Point& p = points_[i];
                product += dot(p.x, p.z) / static_cast<double>(points_.size());
                p.mu = island.contacts[i]->bound.secant(p.x[0]);
                p.missing = p.z - p.scaled(island.reading(*island.contacts[i]));
                p.missing[0] -= norm_from(p.z, 1);
                missing = std::max(missing, norm(p.missing));
            }
            if (round == 0) first = product;
            if (product <= ENOUGH * first && missing <= std::sqrt(ENOUGH) * fastest_) {
                write_impulses(island);
                return true;
            }
            if (!linearise(island, factors)) return false;
            const auto [of_x, of_z] = find_direction(island, factors, 0, false);
            const double left = 1 - std::min(of_x, of_z);
            const auto [part_x, part_z] = find_direction(island, factors, left * left * left * product, true);
            for (Point& p : points_) {
                p.x += part_x * p.dx;
                p.z += part_z * p.dz;
            }
            for (std::size_t b = 0; b < step_.size(); b++) island.w[b] += part_z * step_[b];
        }
        return false;
    }

  private:
    static constexpr int ROUNDS = 40;
    static constexpr double ENOUGH = 1e-10;  // of the first products
    static constexpr double KEPT = 0.99;     // of the way to the boundary

    struct Point {
        double mu;
        V x, z, dx, dz;
        V missing;         // of the equation of z
        V target;          // W^-1 of what the product of W x and W^-1 z lacks
        Mat<d, d> slope;   // of z over y, by s
        typename K::Scaling W;

        V scaled(V v) const {
            for (int i = 1; i < d; i++) v[i] *= mu;
            return v;
        }
        V stiffness(const V& v) const { return W.inverse_times(W.inverse_times(v)); }
    };

    /// Motion without contacts, and products that are all the same; false where there is nothing to solve.
    bool begin(Island<d>& island) {
        points_.resize(island.contacts.size());
        stiffness_.resize(points_.size());
        step_.resize(island.w.size());
        island.w = island.free;
        fastest_ = 0;
        for (std::size_t i = 0; i < points_.size(); i++) {
            const Contact<d>& k = *island.contacts[i];
            if (k.link || k.mode != FrictionMode::LAW) return false;
            points_[i].mu = k.bound.mu;
            fastest_ = std::max(fastest_, norm(points_[i].scaled(island.reading(k))));
        }
        for (Point& p : points_) {
            p.x.fill(0);
            p.z.fill(0);
            p.x[0] = fastest_ / island.least[0];
            p.z[0] = fastest_;
        }
        return fastest_ > 0;
    }

    /// Writes and factorizes the matrix of the step; false where it is singular.
    bool linearise(const Island<d>& island, BlockLU<unknowns>& factors) {
        for (std::size_t i = 0; i < points_.size(); i++) {
            Point& p = points_[i];
            if (!(K::determinant(p.x) > 0) || !(K::determinant(p.z) > 0)) return false;
            p.W = {p.x, p.z};
            const double size = norm_from(p.z, 1);
            for (int a = 0; a < d; a++)
                for (int b = 0; b < d; b++) p.slope[a][b] = a == b ? 1 : (a == 0 && size > 0 ? p.z[b] / size : 0);
            for (int b = 0; b < d; b++) {
                V column;
                for (int a = 0; a < d; a++) column[a] = p.slope[a][b];
                column = p.scaled(p.stiffness(column));
                for (int a = 0; a < d; a++) stiffness_[i][a][b] = column[a] * (b ? p.mu : 1);
            }
        }
        island.assemble(stiffness_, factors);
        return factors.factorize();
    }

    /// The step that takes all products to a target, with second-order terms of the step found before
    /// where wanted; returns which parts of it x and z can go.
    std::array<double, 2> find_direction(const Island<d>& island, BlockLU<unknowns>& factors, double product, bool corrected) {
        for (std::size_t b = 0; b < step_.size(); b++) step_[b] = mul(island.mass[b], island.free[b] - island.w[b]);
        for (std::size_t i = 0; i < points_.size(); i++) {
            Point& p = points_[i];
            const V now = p.W.times(p.x);
            V lacks = -1.0 * K::product(now, now);
            lacks[0] += product;
            if (corrected) lacks = lacks - K::product(p.W.times(p.dx), p.W.inverse_times(p.dz));
            p.target = p.W.inverse_times(K::quotient(now, lacks));
            island.push(*island.contacts[i], p.scaled(p.x + p.target + p.stiffness(mul(p.slope, p.missing))), step_);
        }
        factors.solve(step_);
        std::array<double, 2> parts{1, 1};
        for (std::size_t i = 0; i < points_.size(); i++) {
            Point& p = points_[i];
            p.dz = mul(p.slope, p.scaled(island.moved(*island.contacts[i], step_)) - p.missing);
            p.dx = p.target - p.stiffness(p.dz);
            parts = {std::min(parts[0], KEPT * K::longest(p.x, p.dx)), std::min(parts[1], KEPT * K::longest(p.z, p.dz))};
        }
        return parts;
    }

    void write_impulses(Island<d>& island) const {
        for (std::size_t i = 0; i < points_.size(); i++) island.contacts[i]->impulse = points_[i].scaled(points_[i].x);
        island.move();
    }

    double fastest_ = 0;  // speed of the contacts without impulses
    std::vector<Point> points_;
    std::vector<Mat<d, d>> stiffness_;
    std::vector<Vec<unknowns>> step_;
};

}  // namespace rockslip
