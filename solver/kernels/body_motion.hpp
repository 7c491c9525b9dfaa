// How a meshed body moves as a whole, by sums over its nodes, and displacements that follow from it.
//
// Nodes are d numbers each, one after another. In the plane bodies turn clockwise.
#pragma once

#include "polar.hpp"
#include "rotation.hpp"
#include "small_arrays.hpp"

namespace rockslip {

/// Moment of a vector at an arm, about the axes that angles of meshed bodies are about.
inline Vec<1> turning_moment(const Vec<2>& arm, const Vec<2>& vector) { return -1.0 * moment(arm, vector); }
inline Vec<3> turning_moment(const Vec<3>& arm, const Vec<3>& vector) { return cross(arm, vector); }

/// Motion of a rigid body.
template <int d> struct RigidMotion {
    Vec<d> moved, velocity;     // of the centre of mass, m and m/s
    Vec<Dim<d>::rotations> spin;  // rad/s
};

/// Sums over the nodes of a body: of displacements and velocities by mass, of moments of momenta about the
/// axes of space, and v.M v.
template <int d> struct Momenta {
    static constexpr int axes = Dim<d>::rotations, size = 2 * d + axes + 1;

    Vec<d> moved{}, linear{};  // m u, kg m, and m v, kg m/s
    Vec<axes> angular{};       // (arm + u) x M v, kg m2/s
    double square = 0;         // v.M v, kg m2/s2

    /// Takes the sums as they stand in an array, (size,).
    static Momenta in(const Array<1>& sums) {
        if (sums.length() != size) throw std::invalid_argument("sums of another dimension");
        const double* first = sums.data();
        return {vector_at<d>(first), vector_at<d>(first + d), vector_at<axes>(first + 2 * d), first[size - 1]};
    }

    void fill_in(const Output<1>& sums) const {
        if (sums.length() != size) throw std::invalid_argument("sums of another dimension");
        double* next = std::copy(moved.begin(), moved.end(), sums.begin());
        next = std::copy(linear.begin(), linear.end(), next);
        next = std::copy(angular.begin(), angular.end(), next);
        *next = square;
    }

    /// Sums over nodes by their places from the centre of the undeformed body (n, d), m, displacements, m,
    /// velocities, m/s, momenta M v, kg m/s, and the mass of each unknown in motion along each direction
    /// (d, n d), kg.
    static Momenta of(const Array<2>& arm, const Array<1>& u, const Array<1>& v, const Array<1>& momentum,
                      const Array<2>& directional_mass) {
        Momenta sums;
        for (std::ptrdiff_t n = 0; n < u.length(); n++) {
            for (int i = 0; i < d; i++) {
                sums.moved[i] += directional_mass(i, n) * u[n];
                sums.linear[i] += directional_mass(i, n) * v[n];
            }
            sums.square += v[n] * momentum[n];
        }
        for (std::ptrdiff_t n = 0; n < arm.length(); n++) {
            const Vec<d> place = vector_at<d>(&arm(n, 0)) + vector_at<d>(&u[n * d]);
            sums.angular += turning_moment(place, vector_at<d>(&momentum[n * d]));
        }
        return sums;
    }

    /// The motion of the rigid body that has them, by its mass, kg, the rotation that fits its displacement
    /// best and the inertia tensor of the unrotated body about its centre, in the plane (1, 1), kg m2.
    RigidMotion<d> motion(double mass, const Mat<d, d>& R, const Mat<axes, axes>& inertia) const {
        RigidMotion<d> found;
        for (int i = 0; i < d; i++) {
            found.moved[i] = moved[i] / mass;
            found.velocity[i] = linear[i] / mass;
        }
        const Vec<axes> own = angular - mass * turning_moment(found.moved, found.velocity);
        Vec<axes> spin = to_body(R, own);
        LU<axes> factors{inertia, {}};
        if (!factors.factorize()) throw std::invalid_argument("the inertia tensor of a body is singular");
        factors.solve(spin);
        found.spin = to_space(R, spin);
        return found;
    }
};

/// The rotation that fits displacements of nodes best, from the moments of their mass: M times the places
/// of the nodes from the centre (n, d), kg m, and the sum of these places times their moments, kg m2.
template <int d> Mat<d, d> best_rotation(const Array<1>& u, const Array<2>& moment_row, Mat<d, d> moment) {
    Mat<d, d> moved{};
    for (std::ptrdiff_t n = 0; n < moment_row.length(); n++)
        for (int i = 0; i < d; i++)
            for (int j = 0; j < d; j++) moved[i][j] += u[n * d + i] * moment_row(n, j);
    for (int i = 0; i < d; i++) moment[i] += moved[i];
    return polar_factor(moment);
}

/// How a body turns in a coming step about one axis.
struct Turning {
    double rate;    // change of the angular velocity, rad/s2
    double steady;  // that to count on
    double angle;   // rad
};

/// Takes the angular velocities (rad/s) at its start and at that of the last step, the rate in the step
/// before (rad/s2), and the lengths of the last and the coming step, s.
///
/// What an impact did cannot be counted on: it is the smaller of two changes of the angular velocity, and
/// none where they go different ways.
inline Turning turning_ahead(double spin, double before, double last_rate, double last, double dt) {
    const double rate = (spin - before) / last;
    double steady = std::fabs(rate) < std::fabs(last_rate) ? rate : last_rate;
    if (!(rate * last_rate > 0)) steady = 0;
    return {rate, steady, dt * (spin + 0.5 * dt * steady)};
}

/// Displacements of a body that turns by a rotation and moves on by a way as a whole, its strains unchanged, m.
///
/// Takes places of the nodes from the centre of the undeformed body (n, d), displacements before, and how
/// far the centre is displaced, m; fills in those after.
template <int d>
void move_on(const Array<2>& arm, const Array<1>& u, const Vec<d>& moved, Mat<d, d> turn, const Vec<d>& way,
             const Output<1>& after) {
    for (int i = 0; i < d; i++) turn[i][i] -= 1;
    for (std::ptrdiff_t n = 0; n < arm.length(); n++)
        for (int i = 0; i < d; i++) {
            double found = u[n * d + i] + way[i];
            for (int j = 0; j < d; j++) found += turn[i][j] * (arm(n, j) + u[n * d + j] - moved[j]);
            after[n * d + i] = found;
        }
}

}  // namespace rockslip
