// Motions of meshed bodies, for Python: as a whole, of the points that carry a block, and as the forms of
// cells and the columns of a compliance take and give them.
#include "body_motion.hpp"
#include "python.hpp"
#include "touching_points.hpp"

namespace rockslip::python {
namespace {

/// The dimension in which rotations have so many numbers.
std::ptrdiff_t dimension_of(const Array<1>& vector) { return vector.length() == 1 ? 2 : vector.length(); }

// ---- rotations

void polar_factor(Array<2> moment, Output<2> rotation) {
    in_dimension(moment.length(), [&](auto d) { fill_in(rotation, rockslip::polar_factor(matrix_in<d, d>(moment))); });
}

void best_rotation(Array<1> u, Array<2> moment_row, Array<2> moment, Output<2> rotation) {
    in_dimension(moment.length(), [&](auto d) {
        fill_in(rotation, rockslip::best_rotation<d>(u, moment_row, matrix_in<d, d>(moment)));
    });
}

void turn_by(Array<1> vector, Output<2> rotation) {
    in_dimension(dimension_of(vector), [&](auto d) {
        fill_in(rotation, rotation_by(vector_in<Dim<d>::rotations>(vector)));
    });
}

void vector_of(Array<2> rotation, Output<1> vector) { fill_in(vector, rotation_vector(matrix_in<3, 3>(rotation))); }

void turning_ahead(Array<1> spin, Array<1> before, Array<1> last_rate, double last, double dt, Output<2> turning) {
    for (std::ptrdiff_t i = 0; i < spin.length(); i++) {
        const Turning ahead = rockslip::turning_ahead(spin[i], before[i], last_rate[i], last, dt);
        turning(0, i) = ahead.rate;
        turning(1, i) = ahead.steady;
        turning(2, i) = ahead.angle;
    }
}

// ---- bodies as a whole

void momenta(Array<2> arm, Array<1> u, Array<1> v, Array<1> momentum, Array<2> directional_mass, Output<1> sums) {
    in_dimension(arm.length(1), [&](auto d) { Momenta<d>::of(arm, u, v, momentum, directional_mass).fill_in(sums); });
}

void resultant(Array<1> forces, Output<1> total) {
    const std::ptrdiff_t d = total.length();
    total.fill(0);
    for (std::ptrdiff_t n = 0; n < forces.length(); n += d)
        for (std::ptrdiff_t i = 0; i < d; i++) total[i] += forces[n + i];
}

void velocities(Array<1> sums, double mass, Array<2> rotation, Array<2> inertia, Output<2> motion, Output<1> spin) {
    in_dimension(rotation.length(), [&](auto d) {
        constexpr int axes = Dim<d>::rotations;
        const auto found = Momenta<d>::in(sums).motion(mass, matrix_in<d, d>(rotation), matrix_in<axes, axes>(inertia));
        fill_in(motion[0], found.moved);
        fill_in(motion[1], found.velocity);
        fill_in(spin, found.spin);
    });
}

void move_on(Array<2> arm, Array<1> u, Array<1> moved, Array<1> vector, Array<1> way, Output<1> after) {
    in_dimension(arm.length(1), [&](auto d) {
        const auto turn = rotation_by(vector_in<Dim<d>::rotations>(vector));
        rockslip::move_on<d>(arm, u, vector_in<d>(moved), turn, vector_in<d>(way), after);
    });
}

void turn_all(Array<1> vectors, Array<1> vector, Output<1> turned) {
    in_dimension(dimension_of(vector), [&](auto d) {
        const auto turn = rotation_by(vector_in<Dim<d>::rotations>(vector));
        for (std::ptrdiff_t n = 0; n < vectors.length(); n += d) {
            const auto one = mul(turn, vector_at<d>(&vectors[n]));
            std::copy(one.begin(), one.end(), &turned[n]);
        }
    });
}

// ---- points that carry a block

void touching(Array<2> force, Array<2> place, Mask<1> may_touch, double level, MaskOut<1> touch) {
    touch.fill(false);
    TouchingPoints{force, place, may_touch, level}.each([&](std::ptrdiff_t p) { touch[p] = true; });
}

void mean_slip(Array<2> force, Array<2> place, Mask<1> may_touch, double level, Array<2> reference, Output<1> slip) {
    TouchingPoints{force, place, may_touch, level}.mean_slip(reference, slip);
}

double penetration(Array<2> place, Mask<1> inside) { return rockslip::penetration(place, inside); }

// ---- values cell by cell, and columns

void read_cells(Array<1> values, Indices<2> index, Output<2> table, std::int64_t first) {
    for (std::ptrdiff_t cell = 0; cell < index.length(); cell++) {
        const Indices<1> places = index[cell];
        for (std::ptrdiff_t k = 0; k < places.length(); k++) table(cell, first + k) = values[places[k]];
    }
}

void place_in_cells(Array<1> u, Output<1> values, Indices<2> index, Output<2> table, std::int64_t first) {
    if (std::equal(u.begin(), u.end(), values.begin())) return;
    std::copy(u.begin(), u.end(), values.begin());
    read_cells(values, index, table, first);
}

void add_columns(Array<2> columns, Indices<1> place, Array<2> forces, Output<1> moved) {
    const std::ptrdiff_t d = forces.length(1);
    for (std::ptrdiff_t i = 0; i < place.length(); i++)
        for (std::ptrdiff_t k = 0; k < d; k++) {
            const double force = forces(i, k);
            if (force == 0) continue;
            const Array<1> column = columns[place[i] * d + k];
            for (std::ptrdiff_t n = 0; n < moved.length(); n++) moved[n] += force * column[n];
        }
}

}  // namespace

std::vector<PyMethodDef> motion_functions() {
    return {
        entry<polar_factor>("polar_factor"),
        entry<best_rotation>("best_rotation"),
        entry<turn_by>("turn_by"),
        entry<vector_of>("vector_of"),
        entry<turning_ahead>("turning_ahead"),
        entry<momenta>("momenta"),
        entry<resultant>("resultant"),
        entry<velocities>("velocities"),
        entry<move_on>("move_on"),
        entry<turn_all>("turn_all"),
        entry<touching>("touching"),
        entry<mean_slip>("mean_slip"),
        entry<penetration>("penetration"),
        entry<read_cells>("read_cells"),
        entry<place_in_cells>("place_in_cells"),
        entry<add_columns>("add_columns"),
    };
}

}  // namespace rockslip::python
