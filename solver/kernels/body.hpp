// Rigid bodies: what moves freely, what is fixed to the ground, and a platform on springs.
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

/// Parameters of generalized-alpha, which only the spring of a platform needs.
struct Scheme {
    double alpha_m = 0, alpha_f = 0.5, beta = 0.5;
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
    Vec<Dim<d>::rotations> spin{};  // angular velocity about the body's own axes, rad/s
    Vec<Dim<d>::rotations> turned{};  // rotation vector, carried on over whole turns, rad

    bool moves() const { return mobility != Mobility::FIXED; }
    bool is_platform() const { return mobility == Mobility::PLATFORM; }
    Placement<d> placement() const { return {x, rotation.matrix()}; }

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
