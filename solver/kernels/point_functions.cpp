// What contact points hold, remember and give back, of each interface and of all, for Python.
#include "candidates.hpp"
#include "point_friction.hpp"
#include "point_memory.hpp"
#include "python.hpp"
#include "velocity_level.hpp"

namespace rockslip::python {
namespace {

using Past = Array<2>;

void slipping_points(Array<2> force, Array<2> slip, Array<1> own, Array<1> mu, Array<1> cohesion, MaskOut<1> found) {
    rockslip::slipping_points(force, slip, own, {mu, cohesion}, found);
}

void bounds_by_past(double fixed, double sliding, double decay, double cohesion, bool lost, Past past, Array<1> area,
                    Output<1> mu, Output<1> held) {
    rockslip::bounds_by_past({fixed, sliding, decay, cohesion, lost}, {past}, area, mu, held);
}

void bounds_followed(double fixed, double sliding, double decay, double cohesion, bool lost, Past past, Array<1> area,
                     Array<1> so_far, Array<1> speed, Mask<1> slips, Output<1> mu, Output<1> held) {
    rockslip::bounds_followed({fixed, sliding, decay, cohesion, lost}, {past}, area, so_far, speed, slips, mu, held);
}

std::tuple<double, double> after_step(Array<2> force, Array<2> y, Array<2> old_force, Array<2> old_y,
                                      Array<2> old_anchor, Past old_past, Array<1> softness, Array<1> own,
                                      Array<1> mu, Array<1> cohesion, double step, Output<2> anchor, Output<2> past) {
    return rockslip::after_step({force, y}, {old_force, old_y}, old_anchor, {old_past}, softness, own, {mu, cohesion},
                                step, anchor, {past});
}

std::tuple<double, double> changed_forces(Array<2> before, Array<2> after, Past past_before, Past past_after,
                                          bool rigid) {
    return rockslip::changed_forces({before, {past_before}}, {after, {past_after}}, rigid);
}

void impulse_problem(std::int64_t number, Array<4> W, Array<2> velocity, Array<2> impulse, Array<1> mu,
                     Array<1> cohesion, double slope, Output<4> mobility, Output<2> free, Output<1> left_mu,
                     Output<1> left_cohesion, Output<2> start) {
    rockslip::impulse_problem(static_cast<int>(number), {W, velocity, impulse, {mu, cohesion, slope}},
                              {mobility, free, left_mu, left_cohesion, start});
}

std::tuple<bool, double, double> accept_impulses(std::int64_t number, Array<4> W, Array<2> velocity, Array<2> impulse,
                                                 Array<1> mu, Array<1> cohesion, double slope, double taken,
                                                 Output<2> solution) {
    return rockslip::accept_impulses(static_cast<int>(number), {W, velocity, impulse, {mu, cohesion, slope}}, taken,
                                     solution);
}

std::tuple<bool, double, double> correct_impulses(Array<4> W, Array<2> velocity, Array<2> impulse, Array<1> mu,
                                                  Array<1> cohesion, double slope, double taken, bool lands,
                                                  IndicesOut<1> counts, Output<2> q) {
    return rockslip::correct_impulses({W, velocity, impulse, {mu, cohesion, slope}}, taken, lands, counts, q);
}

std::tuple<std::int64_t, std::int64_t, double> settle(Array<2> y, Indices<1> near, Array<4> W, Array<1> softening,
                                                      Array<1> margin, Mask<1> may_touch, Array<2> anchor,
                                                      Array<1> softness, Array<2> held, Array<1> bed,
                                                      Array<1> round_off, Output<2> force, IndicesOut<1> number,
                                                      Array<1> mu, Array<1> cohesion, bool alone, IndicesOut<1> counts,
                                                      Output<2> q, Output<2> change) {
    return rockslip::settle({y, margin, may_touch, anchor, softness, held, bed, round_off}, {near, W, softening},
                            {mu, cohesion}, alone, force, number, counts, q, change);
}

}  // namespace

std::vector<PyMethodDef> point_functions() {
    return {
        entry<slipping_points>("slipping_points"),
        entry<bounds_by_past>("bounds_by_past"),
        entry<bounds_followed>("bounds_followed"),
        entry<after_step>("after_step"),
        entry<rockslip::stored_energy>("stored_energy"),
        entry<rockslip::squared_change>("squared_change"),
        entry<changed_forces>("changed_forces"),
        entry<impulse_problem>("impulse_problem"),
        entry<accept_impulses>("accept_impulses"),
        entry<correct_impulses>("correct_impulses"),
        entry<rockslip::slip_reversal>("slip_reversal"),
        entry<settle>("settle"),
        entry<rockslip::sinks_in>("sinks_in"),
        entry<rockslip::take_over>("take_over"),
        entry<rockslip::add_softness>("add_softness"),
    };
}

}  // namespace rockslip::python
