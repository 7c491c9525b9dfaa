#include "python.hpp"

namespace rockslip::python {
namespace {

}  // namespace

std::vector<PyMethodDef> law_functions() {
    return {};
}

}  // namespace rockslip::python
