// Small arrays of Python as vectors and matrices of fixed size, and back.
#pragma once

#include <stdexcept>

#include "array.hpp"
#include "linear.hpp"

namespace rockslip {

/// An array (n,) as a vector.
template <int n> Vec<n> vector_in(const Array<1>& array) {
    if (array.length() != n) throw std::invalid_argument("an array is not as long as its dimension asks for");
    Vec<n> found;
    std::copy_n(array.data(), n, found.begin());
    return found;
}

/// An array (rows, columns) as a matrix.
template <int rows, int columns> Mat<rows, columns> matrix_in(const Array<2>& array) {
    if (array.length(0) != rows || array.length(1) != columns)
        throw std::invalid_argument("an array has not the shape that its dimension asks for");
    Mat<rows, columns> found;
    for (int i = 0; i < rows; i++) std::copy_n(array.data() + i * columns, columns, found[i].begin());
    return found;
}

/// d numbers from a place on.
template <int d> Vec<d> vector_at(const double* place) {
    Vec<d> found;
    std::copy_n(place, d, found.begin());
    return found;
}

/// A matrix by its d d entries from a place on.
template <int d> Mat<d, d> matrix_at(const double* place) {
    Mat<d, d> found;
    for (int i = 0; i < d; i++) std::copy_n(place + d * i, d, found[i].begin());
    return found;
}

/// Fills in an array by a vector.
template <std::size_t n> void fill_in(const Output<1>& array, const Numbers<n>& vector) {
    if (array.size() != static_cast<std::ptrdiff_t>(n)) throw std::invalid_argument("an array is no room for a vector");
    std::copy(vector.begin(), vector.end(), array.begin());
}

/// Fills in an array by a matrix.
template <std::size_t r, std::size_t c> void fill_in(const Output<2>& array, const std::array<Numbers<c>, r>& matrix) {
    if (array.size() != static_cast<std::ptrdiff_t>(r * c))
        throw std::invalid_argument("an array is no room for a matrix");
    for (std::size_t i = 0; i < r; i++) fill_in(array[static_cast<std::ptrdiff_t>(i)], matrix[i]);
}

}  // namespace rockslip
