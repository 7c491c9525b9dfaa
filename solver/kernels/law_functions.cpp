// The local problem of few points, and the steps of Newton's method of which Python solves that of many.
#include "dense_problem.hpp"
#include "python.hpp"

namespace rockslip::python {
namespace {

/// A function of a local problem, with the fields of the problem one by one.
template <auto function> struct OfProblem;

template <class R, class... A, R (*function)(const DenseProblem&, A...)> struct OfProblem<function> {
    static R call(std::int64_t d, Array<2> W, Array<1> q, Array<1> mu, Array<1> cohesion, double slope, A... rest) {
        return function({static_cast<int>(d), W, q, {mu, cohesion, slope}}, rest...);
    }
};

template <auto function> PyMethodDef of_problem(const char* name) { return entry<&OfProblem<function>::call>(name); }

/// `project`, told from that of a single impulse.
constexpr void (*PROJECT)(const DenseProblem&, Array<1>, Output<1>, IndicesOut<1>) = project;

/// `solve`, with the fields of the problem one by one.
bool solve_problem(const DenseProblem& problem, Output<1> f, IndicesOut<1> states, IndicesOut<1> counts) {
    return solve(problem.d, problem.W, problem.q, problem.bounds, f, states, counts);
}

}  // namespace

std::vector<PyMethodDef> law_functions() {
    return {
        entry<solve_dense>("solve_dense"),
        entry<lengths>("lengths"),
        entry<error_of>("error_of"),
        of_problem<trial_of>("trial_of"),
        of_problem<PROJECT>("project"),
        of_problem<unknowns>("unknowns"),
        of_problem<equations>("equations"),
        of_problem<write_forces>("write_forces"),
        of_problem<newton>("newton"),
        of_problem<ease>("ease"),
        of_problem<by_proximal_points>("by_proximal_points"),
        of_problem<solve_problem>("solve"),
        entry<solve_points>("solve_points"),
    };
}

}  // namespace rockslip::python
