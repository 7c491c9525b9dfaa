// The module of kernels of meshed bodies that Python imports from this library: `meshed.py` is its face.
#include "python.hpp"

namespace rockslip::python {
namespace {

/// All functions, with the end that Python looks for.
PyMethodDef* table() {
    static std::vector<PyMethodDef> all;
    for (const auto& part : {facet_functions(), law_functions(), link_functions(), motion_functions(), point_functions(), surface_functions()})
        all.insert(all.end(), part.begin(), part.end());
    all.push_back({nullptr, nullptr, 0, nullptr});
    return all.data();
}

}  // namespace
}  // namespace rockslip::python

PyMODINIT_FUNC PyInit_meshed() {
    using namespace rockslip::python;
    PyObject* numpy = PyImport_ImportModule("numpy");
    if (!numpy) return nullptr;
    ndarray = reinterpret_cast<PyTypeObject*>(PyObject_GetAttrString(numpy, "ndarray"));
    Py_DECREF(numpy);
    if (!ndarray) return nullptr;
    static PyModuleDef definition{PyModuleDef_HEAD_INIT, "meshed", nullptr, -1, table(), nullptr, nullptr, nullptr, nullptr};
    return PyModule_Create(&definition);
}
