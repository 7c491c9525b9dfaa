// The module that Python imports from this library; `library.py` loads it.
#include "python.hpp"

#ifndef ROCKSLIP_SOURCES
#define ROCKSLIP_SOURCES ""
#endif

namespace rockslip::python {
namespace {

/// All functions, with the end that Python looks for.
PyMethodDef* table() {
    static std::vector<PyMethodDef> all;
    for (const auto& part : {facet_functions(), law_functions(), link_functions(), motion_functions(), point_functions(), surface_functions(), world_functions()})
        all.insert(all.end(), part.begin(), part.end());
    all.push_back({nullptr, nullptr, 0, nullptr});
    return all.data();
}

}  // namespace
}  // namespace rockslip::python

PyMODINIT_FUNC PyInit_kernels() {
    using namespace rockslip::python;
    PyObject* numpy = PyImport_ImportModule("numpy");
    if (!numpy) return nullptr;
    ndarray = reinterpret_cast<PyTypeObject*>(PyObject_GetAttrString(numpy, "ndarray"));
    Py_DECREF(numpy);
    if (!ndarray) return nullptr;
    static PyModuleDef definition{PyModuleDef_HEAD_INIT, "kernels", nullptr, -1, table(), nullptr, nullptr, nullptr, nullptr};
    PyObject* module = PyModule_Create(&definition);
    // The digest of the sources that this library was compiled from, by build.sh.
    if (module && PyModule_AddStringConstant(module, "SOURCES", ROCKSLIP_SOURCES) < 0) Py_CLEAR(module);
    return module;
}
