// The rotation nearest to a matrix.
#pragma once

#include <utility>

#include "linear.hpp"

namespace rockslip {

/// The rotation nearest to a matrix, its polar factor (Kabsch 1976); not a number where there is none.
inline Mat<2, 2> polar_factor(const Mat<2, 2>& moment) {
    const double c = moment[0][0] + moment[1][1], s = moment[1][0] - moment[0][1];
    const double length = std::sqrt(c * c + s * s);
    return {{{c / length, -s / length}, {s / length, c / length}}};
}

/// In space, where a matrix of rank 2 has one, too: from the singular values U S V^T, by rotations V of
/// pairs of columns until all of them are orthogonal (Hestenes 1958).
///
/// The third singular vectors are the products of the first two: it is a rotation, not a reflection,
/// that is as near as one can be.
inline Mat<3, 3> polar_factor(const Mat<3, 3>& moment) {
    constexpr double ORTHOGONAL = 1e-15;
    constexpr int MOST_SWEEPS = 30;  // five do, but for round-off
    Mat<3, 3> u, v{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // their rows are the columns of moment V and V
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) u[j][i] = moment[i][j];
    bool turned = true;
    for (int sweep = 0; turned && sweep < MOST_SWEEPS; sweep++) {
        turned = false;
        for (int p = 0; p < 2; p++)
            for (int q = p + 1; q < 3; q++) {
                const double a = dot(u[p], u[p]), b = dot(u[q], u[q]), both = dot(u[p], u[q]);
                if (!(std::fabs(both) > ORTHOGONAL * std::sqrt(a * b))) continue;
                const double slope = (b - a) / (2 * both);
                const double t = std::copysign(1.0, slope) / (std::fabs(slope) + std::sqrt(1 + slope * slope));
                const double c = 1 / std::sqrt(1 + t * t), s = c * t;
                for (Mat<3, 3>* rows : {&u, &v}) {
                    Vec<3>&first = (*rows)[p], &second = (*rows)[q];
                    const Vec<3> before = first;
                    first = c * before - s * second;
                    second = s * before + c * second;
                }
                turned = true;
            }
    }
    // The smallest singular value last.
    std::array<int, 3> order{0, 1, 2};
    const auto smaller = [&](int i, int j) { return dot(u[i], u[i]) < dot(u[j], u[j]); };
    if (smaller(order[0], order[1])) std::swap(order[0], order[1]);
    if (smaller(order[1], order[2])) std::swap(order[1], order[2]);
    const int one = order[0], two = order[1];
    const Vec<3> left_one = (1 / norm(u[one])) * u[one], left_two = (1 / norm(u[two])) * u[two];
    const Vec<3> left_three = cross(left_one, left_two), right_three = cross(v[one], v[two]);
    Mat<3, 3> rotation;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            rotation[i][j] = left_one[i] * v[one][j] + left_two[i] * v[two][j] + left_three[i] * right_three[j];
    return rotation;
}

}  // namespace rockslip
