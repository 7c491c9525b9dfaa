// The C interface of the compiled world, called by solver/kernels/world.py.
#include <exception>
#include <limits>

#include "stepper.hpp"

using namespace rockslip;

namespace {

struct Handle {
    int d;
    Stepper<2> plane;
    Stepper<3> space;
    std::vector<double> pairs;  // of the steps of the last run
};

template <class F> auto with_stepper(void* handle, F f) {
    Handle* h = static_cast<Handle*>(handle);
    return h->d == 2 ? f(h->plane) : f(h->space);
}

template <class F> auto with(void* handle, F f) {
    return with_stepper(handle, [&](auto& stepper) { return f(stepper.world); });
}

template <std::size_t n> Numbers<n> read(const double*& from) {
    Numbers<n> x;
    for (double& each : x) each = *from++;
    return x;
}

template <std::size_t n> void write(double*& to, const Numbers<n>& x) {
    for (double each : x) *to++ = each;
}

template <int d> int add_body(World<d>& world, const int* shapes, int parts, int mobility, const double* numbers) {
    Body<d> body;
    body.parts.assign(shapes, shapes + parts);
    body.mobility = static_cast<Mobility>(mobility);
    body.mass = *numbers++;
    body.thickness = *numbers++;
    body.stiffness = *numbers++;
    body.damping = *numbers++;
    Mat<Body<d>::rotations, Body<d>::rotations> inertia;
    for (auto& row : inertia) row = read<Body<d>::rotations>(numbers);
    body.set_inertia(inertia);
    body.spring_force = read<d>(numbers);
    body.x = read<d>(numbers);
    body.rotation.value = read<Rotation<d>::size>(numbers);
    body.v = read<d>(numbers);
    body.spin = read<Dim<d>::rotations>(numbers);
    world.bodies.push_back(body);
    return static_cast<int>(world.bodies.size()) - 1;
}

/// Numbers of the state of a body: centre, rotation, velocity, angular velocity in space, rotation
/// vector, slip, impulse received in the step, penetration.
template <int d> constexpr std::size_t STATE = 4 * d + Rotation<d>::size + 2 * Dim<d>::rotations + 1;

/// Numbers of a step: energies, exchanges, impulse on the ground, closed contacts, iterations, halvings.
template <int d> constexpr std::size_t TOTALS = 11 + d;

/// A link by its numbers: ends, axes (d rows), lengths, strength; of each direction stiffness, damping, gap,
/// whether it resists compression, yield.
template <int d> int add_link(World<d>& world, int a, int b, int axial, const double* numbers) {
    Link<d> link;
    link.a = a;
    link.b = b;
    link.axial = axial != 0;
    link.end_a = read<d>(numbers);
    link.end_b = read<d>(numbers);
    for (auto& row : link.axes) row = read<d>(numbers);
    link.length = read<d>(numbers);
    link.strength = *numbers++;
    for (LinkLaw& law : link.laws) {
        const auto given = read<5>(numbers);
        law = {given[0], given[1], given[2], given[3] != 0, given[4]};
    }
    world.links.push_back(link);
    return static_cast<int>(world.links.size()) - 1;
}

/// Numbers of the state of a link: extensions, forces, plastic parts, 1 where it is broken, when (s), energy lost then.
template <int d> constexpr std::size_t LINK = 3 * d + 3;

template <int d> void write_links(const World<d>& world, double* out) {
    for (const Link<d>& link : world.links) {
        write(out, link.extension);
        write(out, link.mean);
        write(out, link.plastic);
        write(out, Numbers<3>{double(link.broken), link.broken_at, link.lost});
    }
}

template <int d> void write_parts(const World<d>& world, double* out) {
    for (const Vec<d>& impulse : world.support.part_received) write(out, impulse);
}

template <int d> void write_state(const Stepper<d>& stepper, double* of_bodies, double* of_step) {
    const World<d>& world = stepper.world;
    for (std::size_t b = 0; b < world.bodies.size(); b++) {
        const Body<d>& body = world.bodies[b];
        write(of_bodies, body.x);
        write(of_bodies, body.rotation.value);
        write(of_bodies, body.v);
        write(of_bodies, to_space(body.rotation.matrix(), body.spin));
        write(of_bodies, body.turned);
        write(of_bodies, world.support.slip[b]);
        write(of_bodies, world.support.received[b]);
        *of_bodies++ = world.support.penetration[b];
    }
    write(of_step, world.energies());
    const Ledger& l = world.ledger;
    write(of_step, Numbers<5>{l.input, l.friction, l.damping, l.contact, l.numerical});
    write(of_step, world.ground_impulse);
    *of_step++ = world.closed_contacts();
    *of_step++ = static_cast<double>(stepper.local.outcomes.newton);
    *of_step++ = static_cast<double>(world.counts.halved);
}

/// Appends all pairs that have touched: number of the step, a, b, points, normal force, friction on a,
/// gap, slip, place, normal.
template <int d> void write_pairs(const World<d>& world, std::vector<double>& out, int step, double dt) {
    for (const TouchingPair<d>& pair : world.pairs.all) {
        const auto tangents = pair.tangents(pair.normal);
        out.insert(out.end(), {double(step), double(pair.a), double(pair.b), double(pair.points), dot(pair.impulse, pair.normal) / dt});
        for (const Vec<d>& along : tangents) out.push_back(dot(pair.impulse, along) / dt);
        out.push_back(pair.gap);
        out.insert(out.end(), pair.slip.begin() + 1, pair.slip.end());
        out.insert(out.end(), pair.place.begin(), pair.place.end());
        out.insert(out.end(), pair.normal.begin(), pair.normal.end());
    }
}

template <int d> int run(Stepper<d>& stepper, int steps, double dt, double smallest, const double* ground, const double* shift,
                         const double* forces, double* of_bodies, double* of_steps, double* of_links, double* of_parts, std::vector<double>& of_pairs) {
    World<d>& world = stepper.world;
    of_pairs.clear();
    for (int i = 0; i < steps; i++) {
        GroundMotion<d> motion;
        if (ground)
            for (int k = 0; k < d; k++) {
                motion.start[k] = ground[d * i + k] + shift[d * i + k];
                motion.rise[k] = (ground[d * (i + 1) + k] - ground[d * i + k]) / dt;
            }
        const std::size_t all = d * world.forces.size();
        for (std::size_t f = 0; f < world.forces.size(); f++) {
            const double *start = forces + 2 * all * static_cast<std::size_t>(i) + d * f, *end = start + all;
            world.forces[f].start = read<d>(start);
            world.forces[f].end = read<d>(end);
        }
        world.pairs.told = world.pairs.wanted && (world.pairs.every || i + 1 == steps);
        if (!stepper.step(dt, smallest, motion)) return i;
        const auto row = static_cast<std::size_t>(i);
        write_state(stepper, of_bodies + STATE<d> * world.bodies.size() * row, of_steps + TOTALS<d> * row);
        write_links(world, of_links + LINK<d> * world.links.size() * row);
        write_parts(world, of_parts + d * world.support.part_received.size() * row);
        if (world.pairs.told) write_pairs(world, of_pairs, i, dt);
    }
    return steps;
}

/// Numbers one after another, as they are written.
struct Writer {
    std::vector<double> values;

    template <class... T> void operator()(const T&... each) { (put(each), ...); }
    template <class T> void size(const std::vector<T>& of) { put(of.size()); }

  private:
    template <class T> void put(const T& value) { values.push_back(static_cast<double>(value)); }
    template <std::size_t n> void put(const Numbers<n>& x) { values.insert(values.end(), x.begin(), x.end()); }
};

/// The same numbers, as they are read back.
struct Reader {
    const double* next;

    template <class... T> void operator()(T&... each) { (get(each), ...); }
    template <class T> void size(std::vector<T>& of) { of.resize(static_cast<std::size_t>(*next++)); }

  private:
    template <class T> void get(T& value) { value = static_cast<T>(*next++); }
    template <std::size_t n> void get(Numbers<n>& x) { x = read<n>(next); }
};

}  // namespace

#ifndef ROCKSLIP_SOURCES
#define ROCKSLIP_SOURCES ""
#endif

extern "C" {

// Digest of the sources that this library was compiled from, by build.sh; library.py compares it with those beside it.
const char* kernels_sources() { return ROCKSLIP_SOURCES; }

void* world_new(int d, const double* gravity, const double* scheme, int velocity_level) {
    Handle* h = new Handle;
    h->d = d;
    with(h, [&](auto& world) {
        for (double& each : world.gravity) each = *gravity++;
        world.scheme = {scheme[0], scheme[1], scheme[2]};
        world.velocity_level = velocity_level != 0;
    });
    return h;
}

void world_free(void* handle) { delete static_cast<Handle*>(handle); }

int world_half_space(void* handle) {
    Handle* h = static_cast<Handle*>(handle);
    if (h->d == 2) h->plane.world.shapes.push_back(half_space<2>());
    else h->space.world.shapes.push_back(half_space<3>());
    return with(handle, [](auto& world) { return static_cast<int>(world.shapes.size()) - 1; });
}

int world_polygon(void* handle, const double* corners, int count) {
    World<2>& world = static_cast<Handle*>(handle)->plane.world;
    std::vector<Vec<2>> v(count);
    for (Vec<2>& each : v) each = read<2>(corners);
    world.shapes.push_back(polygon(v));
    return static_cast<int>(world.shapes.size()) - 1;
}

int world_polyhedron(void* handle, const double* vertices, int count, const int* loops, const int* sizes, int faces) {
    World<3>& world = static_cast<Handle*>(handle)->space.world;
    std::vector<Vec<3>> v(count);
    for (Vec<3>& each : v) each = read<3>(vertices);
    std::vector<std::vector<int>> all;
    for (int f = 0; f < faces; loops += sizes[f++]) all.emplace_back(loops, loops + sizes[f]);
    world.shapes.push_back(polyhedron(v, all));
    return static_cast<int>(world.shapes.size()) - 1;
}

int world_body(void* handle, const int* shapes, int parts, int mobility, const double* numbers) {
    return with(handle, [&](auto& world) { return add_body(world, shapes, parts, mobility, numbers); });
}

int world_link(void* handle, int a, int b, int axial, const double* numbers) {
    return with(handle, [&](auto& world) { return add_link(world, a, b, axial, numbers); });
}

/// A force on a body at a point in its frame, about its centre.
int world_force(void* handle, int body, const double* arm) {
    return with(handle, [&](auto& world) {
        constexpr int d = std::decay_t<decltype(world)>::dimension;
        world.forces.push_back({body, read<d>(arm), {}, {}});
        return static_cast<int>(world.forces.size()) - 1;
    });
}

void world_law(void* handle, const double* numbers) {
    with(handle, [&](auto& world) {
        world.laws.push_back({numbers[0], numbers[1], numbers[2], numbers[3], numbers[4] != 0, numbers[5]});
    });
}

void world_begin(void* handle, const int* law_of, const int* carriers, const int* counts) {
    with(handle, [&](auto& world) {
        const std::size_t n = world.bodies.size();
        world.law_of.assign(law_of, law_of + n * n);
        world.support.carriers.clear();
        for (std::size_t b = 0; b < n; carriers += counts[b++]) world.support.carriers.emplace_back(carriers, carriers + counts[b]);
        world.begin();
    });
}

/// `forces` has the forces at both ends of each step, (steps, 2, forces, d).
int world_run(void* handle, int steps, double dt, double smallest, const double* ground, const double* shift, const double* forces,
              double* of_bodies, double* of_steps, double* of_links, double* of_parts) {
    std::vector<double>& of_pairs = static_cast<Handle*>(handle)->pairs;
    return with_stepper(handle, [&](auto& stepper) { return run(stepper, steps, dt, smallest, ground, shift, forces, of_bodies, of_steps, of_links, of_parts, of_pairs); });
}

/// From here on what pairs of bodies do to one another is told, of every step of a run or of its last one.
void world_tell_pairs(void* handle, int every) {
    with(handle, [&](auto& world) {
        world.pairs.wanted = true;
        world.pairs.every = every;
    });
}

/// Writes the pairs of the steps of the last run that tell them; returns how many numbers that takes, and only that without room.
long world_pairs(void* handle, double* out) {
    const std::vector<double>& pairs = static_cast<Handle*>(handle)->pairs;
    if (out) std::copy(pairs.begin(), pairs.end(), out);
    return static_cast<long>(pairs.size());
}

void world_state(void* handle, double* of_bodies, double* of_step, double* of_links, double* of_parts) {
    with_stepper(handle, [&](auto& stepper) {
        write_state(stepper, of_bodies, of_step);
        write_links(stepper.world, of_links);
        write_parts(stepper.world, of_parts);
    });
}

/// Writes the collisions since the last call, each as time, a, b, points, place, normal, approach,
/// departure, what a brings, spin before and after, impulse, energy, and forgets them; returns their number, and only that without room.
long world_collisions(void* handle, double* out) {
    return with(handle, [&](auto& world) {
        const long count = static_cast<long>(world.collisions.size());
        if (!out) return count;
        for (const auto& met : world.collisions) {
            write(out, Numbers<4>{met.time, double(met.a), double(met.b), double(met.points)});
            write(out, met.place);
            write(out, met.normal);
            write(out, Numbers<3>{met.approach, met.departure, met.brought});
            write(out, met.spin);
            write(out, met.later_spin);
            write(out, met.impulse);
            *out++ = met.energy;
        }
        world.collisions.clear();
        return count;
    });
}

/// Writes all that steps change, where there is room for it; returns how many numbers that takes.
long world_save(void* handle, double* out, long room) {
    return with(handle, [&](auto& world) {
        Writer writer;
        world.exchange(writer);
        const long count = static_cast<long>(writer.values.size());
        if (count <= room) std::copy(writer.values.begin(), writer.values.end(), out);
        return count;
    });
}

void world_restore(void* handle, const double* saved) {
    with(handle, [&](auto& world) {
        Reader reader{saved};
        world.exchange(reader);
    });
}

void world_reset_deepest(void* handle) {
    with(handle, [](auto& world) { world.deepest = {}; });
}

/// The narrow phase of two shapes at places (centre and rotation, row by row): writes its distance, and
/// for each feature its kind, gap, number of the body with the point (0 or 1), and point or edge;
/// returns how many features there are. For tests.
long world_look(void* handle, int one, int other, const double* places, double margin, double inset, double* out) {
    return with(handle, [&](auto& world) {
        constexpr int d = std::decay_t<decltype(world)>::dimension;
        const Shape<d>&A = world.shapes[one], &B = world.shapes[other];
        PlacedShape<d> a, b;
        for (PlacedShape<d>* placed : {&a, &b}) {
            Placement<d> at;
            at.centre = read<d>(places);
            for (auto& row : at.R) row = read<d>(places);
            placed->place(placed == &a ? A : B, at);
        }
        std::vector<Feature<d>> found;
        *out++ = NarrowPhase<d>(0, 1, A, B, a, b, margin, inset, found).find();
        for (const Feature<d>& each : found) {
            const bool first = each.point_body == 0;
            const double gap = first ? gap_of(each, A, B, a.at, b.at) : gap_of(each, B, A, b.at, a.at);
            write(out, Numbers<4>{double(static_cast<int>(each.kind)), gap, double(each.point_body), double(each.point)});
        }
        return static_cast<long>(found.size());
    });
}

void world_counts(void* handle, double* out) {
    with_stepper(handle, [&](auto& stepper) {
        const auto& world = stepper.world;
        const auto& o = stepper.local.outcomes;
        const auto& c = world.counts;
        const double all[] = {double(o.solves), double(o.warm), double(o.newton), double(o.factorizations), double(o.searched),
                              double(o.softened), double(o.interior), double(o.failed), double(o.loose), o.loosest, double(c.outer), double(c.late),
                              double(c.widened), double(c.halved), double(c.cut), double(c.contacts), double(c.most_contacts), double(c.rungs[0]),
                              double(c.rungs[1]), double(c.rungs[2]), double(c.rungs[3]), double(c.rungs[4]), double(c.unsettled),
                              stepper.local.largest_defect, world.deepest.depth, world.deepest.time, double(world.deepest.a), double(world.deepest.b)};
        std::copy(std::begin(all), std::end(all), out);
    });
}
}
