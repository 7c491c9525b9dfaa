// The law of links, direction by direction, for Python.
#include "link.hpp"
#include "python.hpp"

namespace rockslip::python {
namespace {

/// The law in a row of numbers: stiffness, damping, gap, whether it resists compression, yield.
LinkLaw law_in(const Array<1>& row) { return {row(0), row(1), row(2), row(3) != 0, row(4)}; }

/// Mean forces in a step of dt of what acts for a while, between elastic extensions, and their derivatives over the
/// second; at it alone where dt is infinite.
void link_forces(Array<2> laws, Array<1> from, Array<1> to, Array<1> acts, double dt, Output<1> force,
                 Output<1> slope) {
    for (std::ptrdiff_t i = 0; i < laws.length(); i++) {
        const LinkLaw law = law_in(laws[i]);
        if (std::isinf(dt)) {
            force(i) = law.force(to(i));
            slope(i) = law.slope(to(i));
            continue;
        }
        const auto [impulse, change] = law.impulse(from(i), to(i), acts(i));
        force(i) = -impulse / dt;
        slope(i) = -change / dt;
    }
}

/// Forces and energies of springs at elastic extensions, and by how much these flow there.
void link_springs(Array<2> laws, Array<1> elastic, Output<1> force, Output<1> energy, Output<1> flow) {
    for (std::ptrdiff_t i = 0; i < laws.length(); i++) {
        const LinkLaw law = law_in(laws[i]);
        force(i) = law.force(elastic(i));
        energy(i) = law.energy(elastic(i));
        flow(i) = law.flow(elastic(i));
    }
}

}  // namespace

std::vector<PyMethodDef> link_functions() {
    return {entry<link_forces>("link_forces"), entry<link_springs>("link_springs")};
}

}  // namespace rockslip::python
