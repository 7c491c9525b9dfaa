// Arrays of numbers that Python holds, row after row, seen from here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace rockslip {

/// An array of n axes in one piece, the last index running fastest; what it sees belongs to others.
template <class T, int n> class View {
  public:
    View(T* data, const std::array<std::ptrdiff_t, n>& shape) : data_(data), shape_(shape) {}

    /// What may be written can be read.
    operator View<const T, n>() const { return {data_, shape_}; }

    std::ptrdiff_t length(int axis = 0) const { return shape_[axis]; }

    std::ptrdiff_t size() const {
        std::ptrdiff_t product = 1;
        for (const std::ptrdiff_t length : shape_) product *= length;
        return product;
    }

    T* data() const { return data_; }
    T* begin() const { return data_; }
    T* end() const { return data_ + size(); }

    /// An element, by all indices.
    template <class... Index> T& operator()(Index... index) const {
        static_assert(sizeof...(Index) == n);
        std::ptrdiff_t place = 0;
        int axis = 0;
        ((place = place * shape_[axis++] + static_cast<std::ptrdiff_t>(index)), ...);
        return data_[place];
    }

    /// The part with a first index.
    auto operator[](std::ptrdiff_t index) const -> std::conditional_t<n == 1, T&, View<T, (n > 1 ? n - 1 : 1)>> {
        if constexpr (n == 1) return data_[index];
        else {
            std::array<std::ptrdiff_t, n - 1> rest;
            std::ptrdiff_t stride = 1;
            for (int axis = 1; axis < n; axis++) stride *= rest[axis - 1] = shape_[axis];
            return {data_ + index * stride, rest};
        }
    }

    void fill(const T& value) const {
        for (T& each : *this) each = value;
    }

  private:
    T* data_;
    std::array<std::ptrdiff_t, n> shape_;
};

template <int n> using Array = View<const double, n>;
template <int n> using Output = View<double, n>;
template <int n> using Indices = View<const std::int64_t, n>;
template <int n> using IndicesOut = View<std::int64_t, n>;
template <int n> using Mask = View<const bool, n>;
template <int n> using MaskOut = View<bool, n>;

}  // namespace rockslip
