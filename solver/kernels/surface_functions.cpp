#include "python.hpp"

namespace rockslip::python {
namespace {

}  // namespace

std::vector<PyMethodDef> surface_functions() {
    return {};
}

}  // namespace rockslip::python
