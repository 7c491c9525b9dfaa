// Functions of arrays and numbers for Python: an argument costs some nanoseconds.
//
// An array has to be one of numpy, of the type and number of axes that a function takes, in one piece and
// aligned; it is neither copied nor kept. What C++ throws is raised as RuntimeError.
#pragma once

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000  // one library for all versions of Python from 3.11
#define NPY_NO_DEPRECATED_API NPY_1_7_API_VERSION
#include <Python.h>
#include <numpy/ndarraytypes.h>

#include <exception>
#include <memory>
#include <stdexcept>
#include <tuple>
#include <typeinfo>
#include <utility>
#include <vector>

#include "array.hpp"

namespace rockslip::python {

/// The class `numpy.ndarray`; the module sets it when Python imports it.
inline PyTypeObject* ndarray = nullptr;

/// An argument that is not what a function takes; Python's exception is set.
struct Refused : std::exception {};

template <class T> constexpr const char* NAME = "float64";
template <> inline constexpr const char* NAME<std::int64_t> = "int64";
template <> inline constexpr const char* NAME<bool> = "bool";

/// Whether elements of a type of numpy are a T.
template <class T> bool holds(int type) {
    if constexpr (std::is_same_v<T, double>) return type == NPY_DOUBLE;
    else if constexpr (std::is_same_v<T, bool>) return type == NPY_BOOL;
    else return type == NPY_INT64 || (type == NPY_LONGLONG && sizeof(long long) == sizeof(T));
}

/// Reads an argument of a type.
template <class T> struct Argument;

template <class T, int n> struct Argument<View<T, n>> {
    static View<T, n> read(PyObject* given, int number) {
        using Element = std::remove_const_t<T>;
        const int wanted = std::is_const_v<T> ? NPY_ARRAY_CARRAY_RO : NPY_ARRAY_CARRAY;
        auto* array = reinterpret_cast<PyArrayObject*>(given);
        if (!PyObject_TypeCheck(given, ndarray) || !holds<Element>(PyArray_TYPE(array)) || PyArray_NDIM(array) != n ||
            !PyArray_CHKFLAGS(array, wanted)) {
            PyErr_Format(PyExc_TypeError, "argument %d is no array of %s with %d axes in one piece%s", number, NAME<Element>,
                         n, std::is_const_v<T> ? "" : " that may be written");
            throw Refused{};
        }
        std::array<std::ptrdiff_t, n> shape;
        for (int axis = 0; axis < n; axis++) shape[axis] = PyArray_DIM(array, axis);
        return {static_cast<T*>(PyArray_DATA(array)), shape};
    }
};

template <> struct Argument<double> {
    static double read(PyObject* given, int) {
        const double value = PyFloat_AsDouble(given);
        if (value == -1.0 && PyErr_Occurred()) throw Refused{};
        return value;
    }
};

template <> struct Argument<std::int64_t> {
    static std::int64_t read(PyObject* given, int) {
        const long long value = PyLong_AsLongLong(given);
        if (value == -1 && PyErr_Occurred()) throw Refused{};
        return value;
    }
};

template <> struct Argument<bool> {
    static bool read(PyObject* given, int) {
        const int value = PyObject_IsTrue(given);
        if (value < 0) throw Refused{};
        return value != 0;
    }
};

/// A C++ object that Python holds; a function gets it by reference.
template <class T> struct Argument<T&> {
    static T& read(PyObject* given, int) {
        void* held = PyCapsule_GetPointer(given, typeid(T).name());
        if (!held) throw Refused{};
        return *static_cast<T*>(held);
    }
};

/// Numbers by their names.
using NamedNumbers = std::vector<std::pair<const char*, double>>;

inline PyObject* made(double value) { return PyFloat_FromDouble(value); }
inline PyObject* made(std::int64_t value) { return PyLong_FromLongLong(value); }
inline PyObject* made(bool value) { return PyBool_FromLong(value); }
/// Numbers as bytes, of which numpy makes an array in place.
inline PyObject* made(const std::vector<double>& values) {
    return PyByteArray_FromStringAndSize(reinterpret_cast<const char*>(values.data()), static_cast<Py_ssize_t>(values.size() * sizeof(double)));
}
inline PyObject* made(const NamedNumbers& values) {
    PyObject* found = PyDict_New();
    for (const auto& [name, value] : values) {
        PyObject* number = made(value);
        if (!found || !number || PyDict_SetItemString(found, name, number) < 0) Py_CLEAR(found);
        Py_XDECREF(number);
    }
    return found;
}
template <class T> PyObject* made(std::unique_ptr<T> owned) {
    PyObject* found = PyCapsule_New(owned.get(), typeid(T).name(), [](PyObject* capsule) {
        delete static_cast<T*>(PyCapsule_GetPointer(capsule, typeid(T).name()));
    });
    if (found) owned.release();
    return found;
}
template <class... T> PyObject* made(const std::tuple<T...>& values) {
    PyObject* found = PyTuple_New(sizeof...(T));
    Py_ssize_t place = 0;  // a tuple takes its elements over
    if (found) std::apply([&](const auto&... each) { (PyTuple_SetItem(found, place++, made(each)), ...); }, values);
    return found;
}

/// What a function returns with the dimension as a type: that of the plane or of space.
template <class F> auto in_dimension(std::ptrdiff_t d, const F& function) {
    if (d == 2) return function(std::integral_constant<int, 2>{});
    if (d == 3) return function(std::integral_constant<int, 3>{});
    throw std::invalid_argument("arrays are of neither two nor three dimensions");
}

template <auto function> struct Function;

/// A function as Python calls it.
template <class R, class... A, R (*function)(A...)> struct Function<function> {
    static PyObject* call(PyObject*, PyObject* const* given, Py_ssize_t count) noexcept {
        constexpr Py_ssize_t wanted = sizeof...(A);
        if (count != wanted) return PyErr_Format(PyExc_TypeError, "got %zd arguments; allowed are %zd", count, wanted);
        try {
            return run(given, std::index_sequence_for<A...>{});
        } catch (const std::exception& error) {
            if (!PyErr_Occurred()) PyErr_SetString(PyExc_RuntimeError, error.what());
        }
        return nullptr;
    }

  private:
    template <std::size_t... i> static PyObject* run(PyObject* const* given, std::index_sequence<i...>) {
        std::tuple<A...> all{Argument<A>::read(given[i], static_cast<int>(i) + 1)...};
        if constexpr (std::is_void_v<R>) {
            std::apply(function, all);
            Py_RETURN_NONE;
        } else {
            return made(std::apply(function, all));
        }
    }
};

/// An entry of a module's table.
template <auto function> PyMethodDef entry(const char* name) {
    return {name, reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&Function<function>::call)), METH_FASTCALL, nullptr};
}

// The functions of each file that ends in _functions.cpp.
std::vector<PyMethodDef> facet_functions();
std::vector<PyMethodDef> law_functions();
std::vector<PyMethodDef> link_functions();
std::vector<PyMethodDef> motion_functions();
std::vector<PyMethodDef> point_functions();
std::vector<PyMethodDef> surface_functions();
std::vector<PyMethodDef> world_functions();

}  // namespace rockslip::python
