#include "python.hpp"

namespace rockslip::python {
namespace {

}  // namespace

std::vector<PyMethodDef> point_functions() {
    return {};
}

}  // namespace rockslip::python
