// Rotations: an angle in the plane (anticlockwise), a unit quaternion in space.
//
// A step turns a body by a Cayley vector psi, in space. With the mean R_m of the rotations at both
// ends, R_{n+1} - R_n = skew(psi) R_m exactly; in the plane psi = 2 tan(dtheta/2). Numbers of equations
// here and in the other files are those of docs/method.md: this is (M52).
#pragma once

#include "linear.hpp"

namespace rockslip {

template <int d> struct Rotation;

template <> struct Rotation<2> {
    static constexpr int size = 1;
    Vec<1> value{0};

    Mat<2, 2> matrix() const {
        const double c = std::cos(value[0]), s = std::sin(value[0]);
        return {{{c, -s}, {s, c}}};
    }
    Rotation turned(const Vec<1>& psi) const { return {{value[0] + 2 * std::atan(0.5 * psi[0])}}; }
};

template <> struct Rotation<3> {
    static constexpr int size = 4;
    Vec<4> value{1, 0, 0, 0};

    Mat<3, 3> matrix() const {
        const double w = value[0], x = value[1], y = value[2], z = value[3];
        return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                 {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                 {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
    }
    Rotation turned(const Vec<3>& psi) const {
        const Vec<3> h = 0.5 * psi, v{value[1], value[2], value[3]}, c = cross(h, v);
        const double w = value[0];
        const Vec<4> q{w - dot(h, v), v[0] + w * h[0] + c[0], v[1] + w * h[1] + c[1],
                       v[2] + w * h[2] + c[2]};
        return {(1 / norm(q)) * q};
    }
};

/// The rotation vector of a quaternion; of all that mean the same rotation the one nearest `before`.
inline Vec<3> rotation_vector(const Rotation<3>& rotation, const Vec<3>& before) {
    constexpr double TURN = 2 * 3.14159265358979323846;
    const Vec<4>& q = rotation.value;
    const Vec<3> imaginary{q[1], q[2], q[3]};
    const double sine = norm(imaginary), length = norm(before);
    if (sine < 1e-12) {  // no axis of its own: whole turns keep the old one
        const double turns = std::round(length / TURN);
        if (turns == 0) return (2 * std::copysign(1.0, q[0])) * imaginary;
        return (turns * TURN / length) * before;
    }
    const Vec<3> axis = (1 / sine) * imaginary;
    const double angle = 2 * std::atan2(sine, q[0]);
    return (angle + TURN * std::round((dot(axis, before) - angle) / TURN)) * axis;
}
inline Vec<1> rotation_vector(const Rotation<2>& rotation, const Vec<1>&) { return rotation.value; }

/// The rotation vector of the matrix of a rotation in space, rad: along its axis, as long as its angle.
inline Vec<3> rotation_vector(const Mat<3, 3>& R) {
    // The largest component of the unit quaternion first: the others are divided by it.
    const double trace = R[0][0] + R[1][1] + R[2][2];
    double largest = trace;
    int first = -1;
    for (int i = 0; i < 3; i++)
        if (R[i][i] > largest) {
            largest = R[i][i];
            first = i;
        }
    double w = 1 + trace;
    Vec<3> v{R[2][1] - R[1][2], R[0][2] - R[2][0], R[1][0] - R[0][1]};
    if (first >= 0) {
        const int j = (first + 1) % 3, k = (first + 2) % 3;
        w = v[first];
        v[first] = 1 - trace + 2 * R[first][first];
        v[j] = R[j][first] + R[first][j];
        v[k] = R[k][first] + R[first][k];
    }
    if (w < 0) {
        w = -w;
        v = -1.0 * v;
    }
    const double size = norm(v);
    return (size > 0 ? 2 * std::atan2(size, w) / size : 0.0) * v;
}

/// The rotation by a rotation vector in space, rad; meshed bodies in the plane turn clockwise by an angle.
inline Mat<3, 3> rotation_by(const Vec<3>& vector) {
    const double angle = norm(vector), half = 0.5 * angle;
    const double share = angle > 0 ? std::sin(half) / angle : 0.5;
    return Rotation<3>{{std::cos(half), share * vector[0], share * vector[1], share * vector[2]}}.matrix();
}
inline Mat<2, 2> rotation_by(const Vec<1>& angle) { return Rotation<2>{{-angle[0]}}.matrix(); }

/// Components about the axes of space of a rotational vector given about a body's own axes.
inline Vec<1> to_space(const Mat<2, 2>&, const Vec<1>& own) { return own; }
inline Vec<3> to_space(const Mat<3, 3>& R, const Vec<3>& own) { return mul(R, own); }

/// Components about a body's own axes of a rotational vector in space.
inline Vec<1> to_body(const Mat<2, 2>&, const Vec<1>& in_space) { return in_space; }
inline Vec<3> to_body(const Mat<3, 3>& R, const Vec<3>& in_space) { return transposed_mul(R, in_space); }

}  // namespace rockslip
