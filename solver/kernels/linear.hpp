// Vectors and small matrices of fixed size, and the LU factors of a small matrix.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace rockslip {

template <int n> using Vec = std::array<double, static_cast<std::size_t>(n)>;
template <int rows, int columns> using Mat = std::array<Vec<columns>, static_cast<std::size_t>(rows)>;

/// Numbers of unknowns of a rigid body in d dimensions.
template <int d> struct Dim {
    static constexpr int rotations = d == 2 ? 1 : 3;
    static constexpr int unknowns = d + rotations;
};

/// Components of a rotation of a rigid body.
template <int d> using Turn = Vec<Dim<d>::rotations>;

/// A velocity or an increment of a rigid body: of its centre, then of its rotation.
template <int d> using Motion = Vec<Dim<d>::unknowns>;

/// A matrix over such motions.
template <int d> using MotionMatrix = Mat<Dim<d>::unknowns, Dim<d>::unknowns>;

template <std::size_t n> using Numbers = std::array<double, n>;

template <std::size_t n> void operator+=(Numbers<n>& a, const Numbers<n>& b) {
    for (std::size_t i = 0; i < n; i++) a[i] += b[i];
}
template <std::size_t n> Numbers<n> operator+(Numbers<n> a, const Numbers<n>& b) {
    a += b;
    return a;
}
template <std::size_t n> Numbers<n> operator-(Numbers<n> a, const Numbers<n>& b) {
    for (std::size_t i = 0; i < n; i++) a[i] -= b[i];
    return a;
}
template <std::size_t n> Numbers<n> operator*(double factor, Numbers<n> a) {
    for (double& x : a) x *= factor;
    return a;
}
template <std::size_t n> double dot(const Numbers<n>& a, const Numbers<n>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}
template <std::size_t n> double norm(const Numbers<n>& a) { return std::sqrt(dot(a, a)); }

/// Size of the components from a first one on.
template <std::size_t n> double norm_from(const Numbers<n>& a, std::size_t first) {
    double sum = 0;
    for (std::size_t i = first; i < n; i++) sum += a[i] * a[i];
    return std::sqrt(sum);
}

/// A x.
template <std::size_t r, std::size_t c>
Numbers<r> mul(const std::array<Numbers<c>, r>& A, const Numbers<c>& x) {
    Numbers<r> y;
    for (std::size_t i = 0; i < r; i++) y[i] = dot(A[i], x);
    return y;
}

/// A^T x.
template <std::size_t r, std::size_t c>
Numbers<c> transposed_mul(const std::array<Numbers<c>, r>& A, const Numbers<r>& x) {
    Numbers<c> y{};
    for (std::size_t i = 0; i < r; i++)
        for (std::size_t j = 0; j < c; j++) y[j] += A[i][j] * x[i];
    return y;
}

/// C += factor A B.
template <std::size_t r, std::size_t m, std::size_t c>
void add_product(std::array<Numbers<c>, r>& C, const std::array<Numbers<m>, r>& A,
                 const std::array<Numbers<c>, m>& B, double factor) {
    for (std::size_t i = 0; i < r; i++)
        for (std::size_t l = 0; l < m; l++) {
            const double scaled = factor * A[i][l];
            for (std::size_t j = 0; j < c; j++) C[i][j] += scaled * B[l][j];
        }
}

/// C += A^T B.
template <std::size_t m, std::size_t r, std::size_t c>
void add_transposed_product(std::array<Numbers<c>, r>& C, const std::array<Numbers<r>, m>& A,
                            const std::array<Numbers<c>, m>& B) {
    for (std::size_t l = 0; l < m; l++)
        for (std::size_t i = 0; i < r; i++)
            for (std::size_t j = 0; j < c; j++) C[i][j] += A[l][i] * B[l][j];
}

/// Half the sum of two matrices.
template <std::size_t r, std::size_t c>
std::array<Numbers<c>, r> mean(const std::array<Numbers<c>, r>& A, const std::array<Numbers<c>, r>& B) {
    std::array<Numbers<c>, r> C;
    for (std::size_t i = 0; i < r; i++) C[i] = 0.5 * (A[i] + B[i]);
    return C;
}

/// LU factors with row pivots. Contacts act as springs up to 1e8 times as stiff as inertia: solving
/// with factors is backward stable, multiplying by an inverse loses those eight digits.
template <int n> struct LU {
    Mat<n, n> a;
    std::array<int, static_cast<std::size_t>(n)> pivot;

    /// Factorizes `a` in place; false if it is singular.
    bool factorize() {
        for (int k = 0; k < n; k++) {
            int best = k;
            for (int i = k + 1; i < n; i++)
                if (std::fabs(a[i][k]) > std::fabs(a[best][k])) best = i;
            pivot[k] = best;
            if (best != k) std::swap(a[k], a[best]);
            if (!(std::fabs(a[k][k]) > 0)) return false;
            const double inverse = 1 / a[k][k];
            for (int i = k + 1; i < n; i++) {
                const double factor = a[i][k] *= inverse;
                for (int j = k + 1; j < n; j++) a[i][j] -= factor * a[k][j];
            }
        }
        return true;
    }

    /// Solves for a vector, or for all columns of a matrix, in place.
    template <class X> void solve(X& x) const {
        for (int k = 0; k < n; k++)
            if (pivot[k] != k) std::swap(x[k], x[pivot[k]]);
        for (int i = 1; i < n; i++)
            for (int k = 0; k < i; k++) subtract(x[i], a[i][k], x[k]);
        for (int i = n - 1; i >= 0; i--) {
            for (int k = i + 1; k < n; k++) subtract(x[i], a[i][k], x[k]);
            divide(x[i], a[i][i]);
        }
    }

  private:
    static void subtract(double& x, double factor, double y) { x -= factor * y; }
    template <std::size_t c> static void subtract(Numbers<c>& x, double factor, const Numbers<c>& y) {
        for (std::size_t j = 0; j < c; j++) x[j] -= factor * y[j];
    }
    static void divide(double& x, double divisor) { x /= divisor; }
    template <std::size_t c> static void divide(Numbers<c>& x, double divisor) {
        for (double& each : x) each /= divisor;
    }
};

inline Vec<3> cross(const Vec<3>& a, const Vec<3>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Moment of a force f at an arm r, and with f a unit vector the row of a point on rotations.
inline Vec<1> moment(const Vec<2>& r, const Vec<2>& f) { return {r[0] * f[1] - r[1] * f[0]}; }
inline Vec<3> moment(const Vec<3>& r, const Vec<3>& f) { return cross(r, f); }

}  // namespace rockslip
