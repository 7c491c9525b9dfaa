#include "python.hpp"

namespace rockslip::python {
namespace {

}  // namespace

std::vector<PyMethodDef> facet_functions() {
    return {};
}

}  // namespace rockslip::python
