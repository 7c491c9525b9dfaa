#include "python.hpp"

namespace rockslip::python {
namespace {

}  // namespace

std::vector<PyMethodDef> motion_functions() {
    return {};
}

}  // namespace rockslip::python
