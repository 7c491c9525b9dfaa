// Positions and tractions of the contact points of a meshed surface, and forces on its nodes.
//
// An evaluation reaches the nodes of one cell only, so that a pass takes as long as there are
// evaluations, whatever the size of the body. Forces are added to nodes in the order of the evaluations.
#pragma once

#include <algorithm>

#include "array.hpp"
#include "linear.hpp"

namespace rockslip {

/// An evaluation: a place on a facet, of the one or of several that make a contact point.
template <int d> struct Evaluation {
    std::int64_t point;         // that it belongs to
    const std::int64_t* nodes;  // that it reaches, (k,)
    const double* numbers;      // a row of the table of a surface
    std::ptrdiff_t k;

    /// Its weight in the averages of its point.
    double share() const { return numbers[0]; }
    /// Shape function of a node there.
    double shape(std::ptrdiff_t a) const { return numbers[1 + a]; }
    /// Derivatives of the shape function of a node, (d,), 1/m.
    const double* slopes(std::ptrdiff_t a) const { return numbers + 1 + k + d * a; }
    /// Row i of D with S N = D (2 E), (d, d), Pa.
    const double* stiffness(int i) const { return numbers + 1 + k + k * d + d * d * i; }
};

/// The evaluations of a surface, as `SurfaceRows` of Python has them.
template <int d> class Surface {
  public:
    /// Takes the numbers of points and nodes, (e, 1 + k), and the table, (e, 1 + k + k d + d d d).
    Surface(const Indices<2>& numbers, const Array<2>& table) : numbers_(numbers), table_(table) {}

    std::ptrdiff_t size() const { return numbers_.length(); }

    Evaluation<d> operator[](std::ptrdiff_t e) const {
        const std::ptrdiff_t width = numbers_.length(1);
        const std::int64_t* own = numbers_.data() + e * width;
        return {*own, own + 1, table_.data() + e * table_.length(1), width - 1};
    }

  private:
    Indices<2> numbers_;
    Array<2> table_;
};

/// The values of a `NitscheState` of Python, one after another: x (m) and T (Pa) of all points, and for
/// each evaluation F and S N, the second Piola-Kirchhoff stress on the normal, Pa.
template <int d, class T> struct StateValues {
    T* values;
    std::ptrdiff_t points;

    T* position(std::ptrdiff_t p) const { return values + d * p; }
    T* traction(std::ptrdiff_t p) const { return values + d * (points + p); }
    /// Row i of F.
    T* gradient(std::ptrdiff_t e, int i) const { return values + d * (2 * points + e * (d + 1) + i); }
    T* stress(std::ptrdiff_t e) const { return gradient(e, d); }
};

/// 2 E = H + H^T + H^T H with H = F - I: F^T F - I would lose the digits of small strains.
template <int d> Mat<d, d> twice_strain(const Mat<d, d>& H) {
    Mat<d, d> twice;
    for (int i = 0; i < d; i++)
        for (int j = 0; j < d; j++) {
            twice[i][j] = H[i][j] + H[j][i];
            for (int m = 0; m < d; m++) twice[i][j] += H[m][i] * H[m][j];
        }
    return twice;
}

/// Fills in a state for displacements of the nodes, (n, d), m; `reference` are the points undeformed, m.
template <int d>
void evaluate(const Surface<d>& surface, const double* reference, const double* displacement,
              const StateValues<d, double>& state) {
    std::copy_n(reference, d * state.points, state.position(0));
    std::fill_n(state.traction(0), d * state.points, 0.0);
    for (std::ptrdiff_t e = 0; e < surface.size(); e++) {
        const Evaluation<d> at = surface[e];
        double *x = state.position(at.point), *T = state.traction(at.point);
        Vec<d> place;
        std::copy_n(x, d, place.begin());
        Mat<d, d> H{};
        for (std::ptrdiff_t a = 0; a < at.k; a++) {
            const double *moved = displacement + d * at.nodes[a], *slopes = at.slopes(a);
            const double factor = at.share() * at.shape(a);
            for (int i = 0; i < d; i++) {
                place[i] += factor * moved[i];
                for (int j = 0; j < d; j++) H[i][j] += moved[i] * slopes[j];
            }
        }
        std::copy_n(place.begin(), d, x);
        const Mat<d, d> twice = twice_strain<d>(H);
        Vec<d> stress{};
        for (int i = 0; i < d; i++) {
            H[i][i] += 1.0;
            const double* D = at.stiffness(i);
            for (int j = 0; j < d; j++)
                for (int m = 0; m < d; m++) stress[i] += D[d * j + m] * twice[j][m];
        }
        for (int i = 0; i < d; i++)
            for (int j = 0; j < d; j++) T[i] += at.share() * H[i][j] * stress[j];
        for (int i = 0; i < d; i++) std::copy_n(H[i].begin(), d, state.gradient(e, i));
        std::copy_n(stress.begin(), d, state.stress(e));
    }
}

/// Adds what values of the nodes, (n, d), are at the points to `found`, (p, d).
template <int d> void add_point_values(const Surface<d>& surface, const double* nodal, double* found) {
    for (std::ptrdiff_t e = 0; e < surface.size(); e++) {
        const Evaluation<d> at = surface[e];
        for (std::ptrdiff_t a = 0; a < at.k; a++) {
            const double factor = at.share() * at.shape(a), *values = nodal + d * at.nodes[a];
            for (int i = 0; i < d; i++) found[d * at.point + i] += factor * values[i];
        }
    }
}

/// Adds forces at the points, (p, d), to those on the nodes, (n, d), N.
template <int d> void add_point_forces(const Surface<d>& surface, const double* force, double* nodal) {
    for (std::ptrdiff_t e = 0; e < surface.size(); e++) {
        const Evaluation<d> at = surface[e];
        Vec<d> own;
        std::copy_n(force + d * at.point, d, own.begin());
        for (std::ptrdiff_t a = 0; a < at.k; a++) {
            const double factor = at.share() * at.shape(a);
            double* on = nodal + d * at.nodes[a];
            for (int i = 0; i < d; i++) on[i] += factor * own[i];
        }
    }
}

/// Augmented position y = (g, s) - T/gamma_h of a point, by its place, in place, m: frame has rows normal
/// and tangents.
template <int d>
void take_traction_off(double* y, double inverse_gamma, const double* frame, const double* traction) {
    for (int i = 0; i < d; i++)
        for (int j = 0; j < d; j++) y[i] -= inverse_gamma * frame[d * i + j] * traction[j];
}

/// Adds vectors at the points times the discrete gradient of the traction to forces on nodes, (n, d).
///
/// With F at the mean of both states and the increment of S through it, DT[u_new - u_old] is exactly
/// T_new - T_old: work against a traction is a difference of states (after Simo and Tarnow 1992).
/// `vector(p)` is that of a point.
template <int d, class Vector>
void add_traction_gradient(const Surface<d>& surface, const StateValues<d, const double>& before,
                           const StateValues<d, const double>& after, const Vector& vector, double* nodal) {
    for (std::ptrdiff_t e = 0; e < surface.size(); e++) {
        const Evaluation<d> at = surface[e];
        const Vec<d> weighted = at.share() * vector(at.point);
        Mat<d, d> middle, outer{};
        for (int i = 0; i < d; i++)
            for (int j = 0; j < d; j++) middle[i][j] = 0.5 * (before.gradient(e, i)[j] + after.gradient(e, i)[j]);
        for (int n = 0; n < d; n++) {
            const double* D = at.stiffness(n);
            double along = 0.0;
            for (int i = 0; i < d; i++) along += weighted[i] * middle[i][n];
            for (int j = 0; j < d; j++)
                for (int m = 0; m < d; m++) {
                    const double virtual_stress = 2.0 * along * D[d * j + m];
                    for (int i = 0; i < d; i++) outer[j][i] += virtual_stress * middle[i][m];
                }
        }
        for (int j = 0; j < d; j++) {
            const double stress = 0.5 * (before.stress(e)[j] + after.stress(e)[j]);
            for (int i = 0; i < d; i++) outer[j][i] += stress * weighted[i];
        }
        for (std::ptrdiff_t a = 0; a < at.k; a++) {
            const double* slopes = at.slopes(a);
            double* on = nodal + d * at.nodes[a];
            for (int i = 0; i < d; i++) {
                double sum = on[i];
                for (int j = 0; j < d; j++) sum += slopes[j] * outer[j][i];
                on[i] = sum;
            }
        }
    }
}

/// The factor of the gradient of the traction, theta/gamma_h (w T - w_c f), as `TractionPull` of Python
/// has it.
template <int d> struct TractionPull {
    const double* scale;  // theta w/gamma_h, m2/Pa or m3/Pa, and theta/gamma_h, m/Pa, (p, 2)
    const double* force;  // w_c f, (p, d), N: normal, tangential
    const double* frame;  // rows normal and tangents that they are given in, (d, d)
    double old_weight, new_weight;
    StateValues<d, const double> before, after;

    /// Of a point, as a vector in space.
    Vec<d> operator()(std::ptrdiff_t p) const {
        Vec<d> pulled;
        for (int i = 0; i < d; i++) {
            const double averaged = new_weight * after.traction(p)[i] + old_weight * before.traction(p)[i];
            pulled[i] = scale[2 * p] * averaged;
            for (int k = 0; k < d; k++) pulled[i] -= scale[2 * p + 1] * force[d * p + k] * frame[d * k + i];
        }
        return pulled;
    }
};

}  // namespace rockslip
