// Functions for Python of contact points of meshed surfaces, and of the bodies that they belong to.
#include "nitsche.hpp"
#include "python.hpp"
#include "turned_frame.hpp"

namespace rockslip::python {
namespace {

void evaluate(Indices<2> numbers, Array<2> table, Array<2> reference, Array<2> displacement, Output<2> state) {
    in_dimension(displacement.length(1), [&](auto d) {
        const StateValues<d, double> values{state.data(), reference.length()};
        rockslip::evaluate(Surface<d>(numbers, table), reference.data(), displacement.data(), values);
    });
}

void point_values(Indices<2> numbers, Array<2> table, Array<2> nodal, Output<2> found) {
    found.fill(0.0);
    in_dimension(nodal.length(1),
                 [&](auto d) { add_point_values(Surface<d>(numbers, table), nodal.data(), found.data()); });
}

void add_point_forces(Indices<2> numbers, Array<2> table, Array<2> force, Output<2> nodal) {
    in_dimension(nodal.length(1), [&](auto d) {
        rockslip::add_point_forces(Surface<d>(numbers, table), force.data(), nodal.data());
    });
}

void augment(Array<2> place, Array<2> traction, Array<1> inverse_gamma, Array<2> frame, Output<2> y) {
    std::copy(place.begin(), place.end(), y.begin());
    in_dimension(y.length(1), [&](auto d) {
        for (std::ptrdiff_t p = 0; p < y.length(); p++)
            take_traction_off<d>(y.data() + d * p, inverse_gamma[p], frame.data(), traction.data() + d * p);
    });
}

void add_contact_forces(Indices<2> numbers, Array<2> table, Array<2> before, Array<2> after, Array<2> vectors,
                        Array<2> scale, Array<2> force, Array<2> frame, double old_weight, double new_weight,
                        Output<2> nodal) {
    in_dimension(vectors.length(1), [&](auto d) {
        const Surface<d> surface(numbers, table);
        const std::ptrdiff_t points = vectors.length();
        const StateValues<d, const double> one{before.data(), points}, two{after.data(), points};
        const TractionPull<d> pull{scale.data(), force.data(), frame.data(), old_weight, new_weight, one, two};
        rockslip::add_point_forces(surface, vectors.data(), nodal.data());
        add_traction_gradient(surface, one, two, pull, nodal.data());
    });
}

void into_frame(Array<1> vectors, Array<3> turns, double factor, Output<1> turned, Output<1> total) {
    in_dimension(total.length(), [&](auto d) {
        const Turns<d> at(turns.data());
        fill_in(total, rockslip::into_frame<d>(vectors.data(), turned.length() / d, at.middle, factor, turned.data()));
    });
}

void point_vectors(Array<2> force, double weight, Array<3> frames, Array<2> rotation, Output<2> vectors) {
    in_dimension(force.length(1), [&](auto d) {
        const auto turned = matrix_at<d>(rotation.data());
        for (std::ptrdiff_t p = 0; p < force.length(); p++)
            fill_in(vectors[p], point_vector<d>(force[p].data(), weight, frames[p].data(), turned));
    });
}

void out_of_frame(Array<1> nodes, Array<1> others, Array<2> rotation, Output<1> moved) {
    in_dimension(rotation.length(), [&](auto d) {
        rockslip::out_of_frame<d>(nodes.data(), others.data(), nodes.length() / d, matrix_at<d>(rotation.data()),
                                  moved.data());
    });
}

void add_shift(Array<2> vectors, Array<2> shift, Output<1> nodes) {
    in_dimension(shift.length(), [&](auto d) {
        rockslip::add_shift<d>(vectors.data(), vectors.length(), matrix_at<d>(shift.data()), nodes.data(),
                               nodes.length() / d);
    });
}

void add_places(Output<2> moved, std::int64_t first, double sign, Array<2> motions, Array<3> frame,
                Array<2> rotation) {
    in_dimension(motions.length(1), [&](auto d) {
        rockslip::add_places<d>(moved.data() + d * first, motions.length(), sign, motions.data(), frame,
                                matrix_at<d>(rotation.data()));
    });
}

void read_points(Indices<1> start, Indices<1> column, Array<1> weight, Array<1> nodes, Output<2> read) {
    read.fill(0.0);
    for (std::ptrdiff_t row = 0; row < start.length() - 1; row++)
        for (std::int64_t a = start[row]; a < start[row + 1]; a++) read.data()[row] += weight[a] * nodes[column[a]];
}

void mark_ports(Indices<1> near, std::int64_t first, std::int64_t count, std::int64_t port, Indices<2> nodes,
                MaskOut<1> used) {
    rockslip::mark_ports(near, {first, count}, port, nodes, used);
}

void add_loads(Indices<1> near, std::int64_t first, std::int64_t count, std::int64_t port, Indices<2> nodes,
               Array<2> weights, double sign, Indices<1> ports, Output<2> load) {
    rockslip::add_loads(near, {first, count}, port, nodes, weights, sign, ports, load);
}

void add_compliance(Output<4> W, double weight, Array<3> frames, Array<3> turns, Array<4> C, Array<1> share) {
    in_dimension(frames.length(1), [&](auto d) {
        rockslip::add_compliance<d>(W.data(), weight, frames, Turns<d>(turns.data()), C.data(), share.data());
    });
}

void turn(Array<2> start, Array<2> rotation, double inertia, Output<3> turns) {
    in_dimension(rotation.length(), [&](auto d) {
        const Turns<d> found(matrix_at<d>(start.data()), matrix_at<d>(rotation.data()), inertia);
        fill_in(turns[0], found.rotation);
        fill_in(turns[1], found.middle);
        fill_in(turns[2], found.shift);
    });
}

double largest_turn(Array<3> now, Array<3> before) { return rockslip::largest_turn(now, before); }

}  // namespace

std::vector<PyMethodDef> surface_functions() {
    return {
        entry<evaluate>("evaluate"),
        entry<point_values>("point_values"),
        entry<add_point_forces>("add_point_forces"),
        entry<augment>("augment"),
        entry<add_contact_forces>("add_contact_forces"),
        entry<into_frame>("into_frame"),
        entry<point_vectors>("point_vectors"),
        entry<out_of_frame>("out_of_frame"),
        entry<add_shift>("add_shift"),
        entry<add_places>("add_places"),
        entry<read_points>("read_points"),
        entry<mark_ports>("mark_ports"),
        entry<add_loads>("add_loads"),
        entry<add_compliance>("add_compliance"),
        entry<turn>("turn"),
        entry<largest_turn>("largest_turn"),
    };
}

}  // namespace rockslip::python
