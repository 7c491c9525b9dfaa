// Rigid bodies: what moves freely, what is fixed to the ground, and a platform on springs; what acts on all, and on one.
#pragma once

#include "rotation.hpp"
#include "shape.hpp"

namespace rockslip {

enum class Mobility { FREE, FIXED, PLATFORM };

/// Acceleration of the ground over a step: linear in time.
template <int d> struct GroundMotion {
    Vec<d> start{};  // at the start of the step, m/s2
    Vec<d> rise{};   // m/s3

    GroundMotion later(double time) const { return {start + time * rise, rise}; }
    /// The mean over a step of a length, s.
    Vec<d> mean(double length) const { return start + (0.5 * length) * rise; }
};

/// A force on a body at a point of it, along directions in space.
template <int d> struct AppliedForce {
    int body = 0;
    Vec<d> arm{};           // of the point from the centre, in the frame of the body, m
    Vec<d> start{}, end{};  // at both ends of a step, in between linear, N

    /// Its value when a share of the step has passed.
    Vec<d> at(double share) const { return start + share * (end - start); }
};

template <int d> struct Body {
    static constexpr int rotations = Dim<d>::rotations, unknowns = Dim<d>::unknowns;

    std::vector<int> parts;         // numbers of the shapes that make it up
    double radius = 0;              // of the sphere about the centre that holds it, m
    Mobility mobility = Mobility::FREE;
    double mass = 1;                // kg
    double thickness = 1;           // of a body in the plane, m
    Mat<rotations, rotations> inertia{};  // about the centre and the body's own axes, kg m2
    Mat<rotations, rotations> inverse_inertia{};
    double stiffness = 0, damping = 0;  // of a platform, N/m and N s/m
    Vec<d> spring_force{};          // p: inertia force of a platform against its spring, N

    Vec<d> x{}, v{};              // centre (m) and its velocity (m/s), relative to the ground
    Rotation<d> rotation;
    Turn<d> spin{};               // angular velocity about the body's own axes, rad/s
    Turn<d> turned{};             // rotation vector, carried on over whole turns, rad

    bool moves() const { return mobility != Mobility::FIXED; }
    bool is_platform() const { return mobility == Mobility::PLATFORM; }
    bool is_free() const { return mobility == Mobility::FREE; }
    Placement<d> placement() const { return {x, rotation.matrix()}; }

    /// Velocities of the centre and, about the axes of space, of the rotation, at a rotation R.
    Motion<d> velocities(const Mat<d, d>& R) const {
        const Turn<d> turning = to_space(R, spin);
        Motion<d> w;
        for (int i = 0; i < d; i++) w[i] = v[i];
        for (int i = 0; i < rotations; i++) w[d + i] = turning[i];
        return w;
    }

    /// Writes M and its inverse about the axes of space, at a rotation R.
    void write_mass(const Mat<d, d>& R, MotionMatrix<d>& M, MotionMatrix<d>& inverse) const {
        M = {};
        inverse = {};
        for (int i = 0; i < unknowns; i++) M[i][i] = inverse[i][i] = 1;  // unknowns that a platform lacks
        for (int i = 0; i < (is_platform() ? d - 1 : d); i++) {
            M[i][i] = mass;
            inverse[i][i] = 1 / mass;
        }
        if (is_platform()) return;
        for (int i = 0; i < rotations; i++)
            for (int j = 0; j < rotations; j++) {
                double direct = 0, reciprocal = 0;
                for (int k = 0; k < rotations; k++)
                    for (int l = 0; l < rotations; l++) {
                        const double turn = d == 2 ? 1 : R[i][k] * R[j][l];
                        direct += turn * inertia[k][l];
                        reciprocal += turn * inverse_inertia[k][l];
                    }
                M[d + i][d + j] = direct;
                inverse[d + i][d + j] = reciprocal;
            }
    }

    /// Where an increment (dx, psi) of the unknowns takes the body.
    Placement<d> moved(const Vec<unknowns>& increment) const {
        Vec<d> place = x;
        Vec<rotations> psi;
        for (int i = 0; i < d; i++) place[i] += increment[i];
        for (int i = 0; i < rotations; i++) psi[i] = increment[d + i];
        return {place, is_platform() ? rotation.matrix() : rotation.turned(psi).matrix()};
    }

    double kinetic_energy() const {
        double twice = mass * dot(v, v);
        return 0.5 * (twice + dot(spin, mul(inertia, spin)));
    }

    void set_inertia(const Mat<rotations, rotations>& about_centre) {
        inertia = about_centre;
        inverse_inertia = {};
        for (int i = 0; i < rotations; i++) inverse_inertia[i][i] = 1;
        LU<rotations> factors{inertia, {}};
        if (!factors.factorize()) throw std::invalid_argument("the inertia of a body is singular");
        factors.solve(inverse_inertia);
    }
};

}  // namespace rockslip
