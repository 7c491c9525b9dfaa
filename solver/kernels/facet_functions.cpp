// Facets of a face, for Python.
#include "facets.hpp"
#include "python.hpp"

namespace rockslip::python {
namespace {

template <int d>
void project(const FacetShapes& shapes, const Array<2>& position, const Array<2>& carrier, const Array<2>& rows,
             const Output<2>& place, const ClosestPoints& closest) {
    const auto frame = matrix_in<d, d>(rows);
    FacetProjection<d> face(shapes, carrier, frame);
    for (std::ptrdiff_t p = 0; p < position.length(); p++)
        face.project(mul(frame, vector_at<d>(&position(p, 0))), p, place[p], closest);
}

void project_onto_facets(Indices<2> facets, Indices<2> powers, Array<2> factors, Array<3> derivatives,
                         Array<4> undeformed, Indices<2> meeting, Indices<1> first, Array<2> along,
                         std::int64_t corners, double margin, Array<2> position, Array<2> carrier, Array<2> frame,
                         Output<2> place, IndicesOut<2> nodes, Output<2> weights, Output<2> slope, Output<3> stretch,
                         MaskOut<1> beyond_edge) {
    const FacetShapes shapes{facets, powers, factors, derivatives, undeformed, meeting, first, along, corners, margin};
    const ClosestPoints closest{nodes, weights, slope, stretch, beyond_edge};
    in_dimension(frame.length(), [&](auto d) { project<d>(shapes, position, carrier, frame, place, closest); });
}

void interpolated(Indices<2> nodes, Array<2> weights, Array<2> values, Output<2> found) {
    found.fill(0);
    for (std::ptrdiff_t p = 0; p < nodes.length(); p++)
        for (std::ptrdiff_t a = 0; a < nodes.length(1); a++)
            for (std::ptrdiff_t i = 0; i < values.length(1); i++) found(p, i) += weights(p, a) * values(nodes(p, a), i);
}

void add_spread(Indices<2> nodes, Array<2> weights, double factor, Array<2> vectors, Output<2> target) {
    for (std::ptrdiff_t p = 0; p < nodes.length(); p++)
        for (std::ptrdiff_t a = 0; a < nodes.length(1); a++) {
            const double share = factor * weights(p, a);
            for (std::ptrdiff_t i = 0; i < vectors.length(1); i++) target(nodes(p, a), i) += share * vectors(p, i);
        }
}

template <int d>
void fill_in_forces(const FootPoints& old, const FootPoints& now, const Array<2>& rows, double facet,
                    const Array<2>& forces, const Output<2>& vectors) {
    const auto frame = matrix_in<d, d>(rows);
    vectors.fill(0);
    for (std::ptrdiff_t p = 0; p < forces.length(); p++) {
        const auto force = vector_at<d>(&forces(p, 0));
        if (force == Vec<d>{}) continue;
        fill_in(vectors[p], force_in_space(ProjectionIncrement<d>(p, old, now, frame, facet), frame, force));
    }
}

template <int d>
double sum_of_defects(const FootPoints& old, const FootPoints& now, const Array<2>& rows, double facet,
                      const Array<2>& forces) {
    const auto frame = matrix_in<d, d>(rows);
    double total = 0;
    for (std::ptrdiff_t p = 0; p < forces.length(); p++) {
        const auto force = vector_at<d>(&forces(p, 0));
        if (!(force[0] > 0)) continue;
        const ProjectionIncrement<d> step(p, old, now, frame, facet);
        if (step.share < 1) add_work_defect(step, force, total);
    }
    return total;
}

void forces_in_space(Indices<2> old_nodes, Array<2> old_weights, Array<2> old_slope, Array<3> old_stretch,
                     Array<2> old_place, Array<2> old_position, Indices<2> nodes, Array<2> weights, Array<2> slope,
                     Array<3> stretch, Array<2> place, Array<2> position, Array<2> frame, double facet, Array<2> force,
                     Output<2> vectors) {
    const FootPoints old{old_nodes, old_weights, old_slope, old_stretch, old_place, old_position};
    const FootPoints now{nodes, weights, slope, stretch, place, position};
    in_dimension(frame.length(), [&](auto d) { fill_in_forces<d>(old, now, frame, facet, force, vectors); });
}

double work_defect(Indices<2> old_nodes, Array<2> old_weights, Array<2> old_slope, Array<3> old_stretch,
                   Array<2> old_place, Array<2> old_position, Indices<2> nodes, Array<2> weights, Array<2> slope,
                   Array<3> stretch, Array<2> place, Array<2> position, Array<2> frame, double facet, Array<2> force) {
    const FootPoints old{old_nodes, old_weights, old_slope, old_stretch, old_place, old_position};
    const FootPoints now{nodes, weights, slope, stretch, place, position};
    return in_dimension(frame.length(), [&](auto d) { return sum_of_defects<d>(old, now, frame, facet, force); });
}

}  // namespace

std::vector<PyMethodDef> facet_functions() {
    return {
        entry<project_onto_facets>("project_onto_facets"), entry<interpolated>("interpolated"),
        entry<add_spread>("add_spread"),                   entry<forces_in_space>("forces_in_space"),
        entry<work_defect>("work_defect"),
    };
}

}  // namespace rockslip::python
