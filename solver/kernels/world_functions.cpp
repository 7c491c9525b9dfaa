// The world of rigid bodies for Python: solver/kernels/world.py is its face.
#include <variant>

#include "python.hpp"
#include "small_arrays.hpp"
#include "stepper.hpp"

namespace rockslip::python {
namespace {

/// A world in the plane or in space, with its steps.
using AnyStepper = std::variant<Stepper<2>, Stepper<3>>;

/// What a function returns of the world inside, whichever it is.
template <class F> auto with(AnyStepper& held, const F& function) {
    return std::visit([&](auto& stepper) { return function(stepper.world); }, held);
}

/// The dimension of a world.
template <class W> constexpr int DIMENSION = std::decay_t<W>::dimension;

template <class T> std::int64_t number_of_last(const std::vector<T>& all) { return static_cast<std::int64_t>(all.size()) - 1; }

/// Numbers one after another, as they are written.
struct Writer {
    std::vector<double> values;

    template <class... T> void operator()(const T&... each) { (put(each), ...); }
    template <class T> void size(const std::vector<T>& of) { put(of.size()); }

    /// Fills in an array by what was written, and begins anew.
    template <int n> void fill(const Output<n>& array) {
        if (array.size() != static_cast<std::ptrdiff_t>(values.size())) throw std::invalid_argument("an array is no room for what a world tells");
        std::copy(values.begin(), values.end(), array.begin());
        values.clear();
    }

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
    template <class T, std::size_t n> void get(std::array<T, n>& x) {
        for (T& each : x) get(each);
    }
};

/// Lists of numbers, one after another, by how many each has.
std::vector<std::vector<int>> lists(Indices<1> numbers, Indices<1> sizes) {
    std::vector<std::vector<int>> found;
    const std::int64_t* next = numbers.begin();
    for (const std::int64_t size : sizes) {
        found.emplace_back(next, next + size);
        next += size;
    }
    return found;
}

// ---- what there is

std::unique_ptr<AnyStepper> world_new(std::int64_t dimension, Array<1> gravity, Array<1> scheme, bool velocity_level) {
    auto held = std::make_unique<AnyStepper>();
    if (dimension == 3) held->emplace<Stepper<3>>();
    with(*held, [&](auto& world) {
        world.gravity = vector_in<DIMENSION<decltype(world)>>(gravity);
        world.scheme = {scheme[0], scheme[1], scheme[2]};
        world.velocity_level = velocity_level;
    });
    return held;
}

std::int64_t world_half_space(AnyStepper& held) {
    return with(held, [](auto& world) {
        world.shapes.push_back(half_space<DIMENSION<decltype(world)>>());
        return number_of_last(world.shapes);
    });
}

template <int d> std::vector<Vec<d>> points(Array<2> given) {
    std::vector<Vec<d>> found(static_cast<std::size_t>(given.length()));
    for (std::size_t i = 0; i < found.size(); i++) found[i] = vector_in<d>(given[static_cast<std::ptrdiff_t>(i)]);
    return found;
}

std::int64_t world_polygon(AnyStepper& held, Array<2> corners) {
    World<2>& world = std::get<Stepper<2>>(held).world;
    world.shapes.push_back(polygon(points<2>(corners)));
    return number_of_last(world.shapes);
}

std::int64_t world_polyhedron(AnyStepper& held, Array<2> vertices, Indices<1> loops, Indices<1> sizes) {
    World<3>& world = std::get<Stepper<3>>(held).world;
    world.shapes.push_back(polyhedron(points<3>(vertices), lists(loops, sizes)));
    return number_of_last(world.shapes);
}

void world_body(AnyStepper& held, Indices<1> shapes, std::int64_t mobility, Array<1> numbers) {
    with(held, [&](auto& world) {
        Body<DIMENSION<decltype(world)>> body;
        body.parts.assign(shapes.begin(), shapes.end());
        body.mobility = static_cast<Mobility>(mobility);
        auto inertia = body.inertia;
        Reader read{numbers.data()};
        read(body.mass, body.thickness, body.stiffness, body.damping, inertia, body.spring_force, body.x, body.rotation.value, body.v, body.spin);
        body.set_inertia(inertia);
        world.bodies.push_back(body);
    });
}

void world_link(AnyStepper& held, std::int64_t a, std::int64_t b, bool axial, Array<1> numbers) {
    with(held, [&](auto& world) {
        Link<DIMENSION<decltype(world)>> link;
        link.a = static_cast<int>(a);
        link.b = static_cast<int>(b);
        link.axial = axial;
        Reader read{numbers.data()};
        read(link.end_a, link.end_b, link.axes, link.length, link.strength);
        for (LinkLaw& law : link.laws) read(law.stiffness, law.damping, law.gap, law.compression, law.yield);
        world.links.push_back(link);
    });
}

void world_force(AnyStepper& held, std::int64_t body, Array<1> arm) {
    with(held, [&](auto& world) { world.forces.push_back({static_cast<int>(body), vector_in<DIMENSION<decltype(world)>>(arm), {}, {}}); });
}

void world_begin(AnyStepper& held, Array<2> laws, Indices<2> law_of, Indices<1> carriers, Indices<1> counts) {
    with(held, [&](auto& world) {
        for (std::ptrdiff_t i = 0; i < laws.length(); i++) {
            Reader read{laws[i].data()};
            ContactLaw& law = world.laws.emplace_back();
            read(law.static_friction, law.dynamic_friction, law.decay, law.cohesion, law.loses_cohesion, law.restitution);
        }
        world.law_of.assign(law_of.begin(), law_of.end());
        world.support.carriers = lists(carriers, counts);
        world.begin();
    });
}

/// From here on what pairs of bodies do to one another is told, of every step of a run or of its last one.
void world_tell_pairs(AnyStepper& held, bool every) {
    with(held, [&](auto& world) {
        world.pairs.wanted = true;
        world.pairs.every = every;
    });
}

// ---- steps

/// Where a step is told: rows of numbers for each body, of the whole, for each link and each part.
struct Rows {
    Output<2> bodies;
    Output<1> whole;
    Output<2> links, parts;
};

template <int d> void write_state(const Stepper<d>& stepper, const Rows& rows) {
    static thread_local Writer write;
    const World<d>& world = stepper.world;
    for (std::size_t b = 0; b < world.bodies.size(); b++) {
        const Body<d>& body = world.bodies[b];
        write(body.x, body.rotation.value, body.v, to_space(body.rotation.matrix(), body.spin), body.turned);
        write(world.support.slip[b], world.support.received[b], world.support.penetration[b]);
    }
    write.fill(rows.bodies);
    const Ledger& l = world.ledger;
    write(world.energies(), l.input, l.friction, l.damping, l.contact, l.numerical, world.ground_impulse);
    write(world.closed_contacts(), stepper.local.outcomes.newton, world.counts.halved);
    write.fill(rows.whole);
    for (const Link<d>& link : world.links) write(link.extension, link.mean, link.plastic, link.broken, link.broken_at, link.lost);
    write.fill(rows.links);
    for (const Vec<d>& impulse : world.support.part_received) write(impulse);
    write.fill(rows.parts);
}

/// Writes all pairs that have touched after a step.
template <int d> void write_pairs(const World<d>& world, Writer& write, std::ptrdiff_t step, double dt) {
    for (const TouchingPair<d>& pair : world.pairs.all) {
        write(step, pair.a, pair.b, pair.points, dot(pair.impulse, pair.normal) / dt);
        for (const Vec<d>& along : pair.tangents(pair.normal)) write(dot(pair.impulse, along) / dt);
        write(pair.gap);
        for (int i = 1; i < d; i++) write(pair.slip[i]);
        write(pair.place, pair.normal);
    }
}

std::tuple<std::int64_t, std::vector<double>> world_run(AnyStepper& held, double dt, double smallest, Array<2> ground, Array<2> shift, Array<4> forces,
                                                        Output<3> of_bodies, Output<2> of_steps, Output<3> of_links, Output<3> of_parts) {
    return std::visit(
        [&](auto& stepper) -> std::tuple<std::int64_t, std::vector<double>> {
            auto& world = stepper.world;
            constexpr int d = DIMENSION<decltype(world)>;
            Writer pairs;
            std::ptrdiff_t i = 0;
            for (; i < of_steps.length(); i++) {
                const Vec<d> start = vector_in<d>(ground[i]), end = vector_in<d>(ground[i + 1]);
                GroundMotion<d> motion;
                motion.start = start + vector_in<d>(shift[i]);
                for (int k = 0; k < d; k++) motion.rise[k] = (end[k] - start[k]) / dt;
                for (std::size_t f = 0; f < world.forces.size(); f++) {
                    world.forces[f].start = vector_in<d>(forces[i][0][static_cast<std::ptrdiff_t>(f)]);
                    world.forces[f].end = vector_in<d>(forces[i][1][static_cast<std::ptrdiff_t>(f)]);
                }
                world.pairs.told = world.pairs.wanted && (world.pairs.every || i + 1 == of_steps.length());
                if (!stepper.step(dt, smallest, motion)) break;
                write_state(stepper, {of_bodies[i], of_steps[i], of_links[i], of_parts[i]});
                if (world.pairs.told) write_pairs(world, pairs, i, dt);
            }
            return {i, std::move(pairs.values)};
        },
        held);
}

void world_state(AnyStepper& held, Output<3> of_bodies, Output<2> of_step, Output<3> of_links, Output<3> of_parts) {
    std::visit([&](auto& stepper) { write_state(stepper, {of_bodies[0], of_step[0], of_links[0], of_parts[0]}); }, held);
}

/// The collisions since the last call, which are then forgotten.
std::vector<double> world_collisions(AnyStepper& held) {
    return with(held, [](auto& world) {
        Writer write;
        for (const auto& met : world.collisions) {
            write(met.time, met.a, met.b, met.points, met.place, met.normal, met.approach, met.departure, met.brought);
            write(met.spin, met.later_spin, met.impulse, met.energy);
        }
        world.collisions.clear();
        return std::move(write.values);
    });
}

// ---- checkpoints and counts

std::vector<double> world_save(AnyStepper& held) {
    return with(held, [](auto& world) {
        Writer writer;
        world.exchange(writer);
        return std::move(writer.values);
    });
}

void world_restore(AnyStepper& held, Array<1> saved) {
    with(held, [&](auto& world) {
        Reader reader{saved.data()};
        world.exchange(reader);
    });
}

void world_reset_deepest(AnyStepper& held) {
    with(held, [](auto& world) { world.deepest = {}; });
}

NamedNumbers world_counts(AnyStepper& held) {
    return std::visit(
        [](auto& stepper) -> NamedNumbers {
            const auto& world = stepper.world;
            const auto& o = stepper.local.outcomes;
            const auto& c = world.counts;
            const auto number = [](auto value) { return static_cast<double>(value); };
            return {{"solves", number(o.solves)}, {"warm", number(o.warm)}, {"newton", number(o.newton)},
                    {"factorizations", number(o.factorizations)}, {"softened", number(o.softened)},
                    {"failed", number(o.failed)}, {"loose", number(o.loose)}, {"loosest", o.loosest},
                    {"outer", number(c.outer)}, {"late", number(c.late)}, {"widened", number(c.widened)}, {"halved", number(c.halved)},
                    {"cut", number(c.cut)}, {"contacts", number(c.contacts)}, {"most_contacts", number(c.most_contacts)},
                    {"rung_0", number(c.rungs[0])}, {"rung_1", number(c.rungs[1])}, {"rung_2", number(c.rungs[2])},
                    {"rung_3", number(c.rungs[3])}, {"rung_4", number(c.rungs[4])}, {"unsettled", number(c.unsettled)},
                    {"largest_defect", stepper.local.largest_defect}, {"deepest", world.deepest.depth}, {"deepest_at", world.deepest.time},
                    {"deepest_a", number(world.deepest.a)}, {"deepest_b", number(world.deepest.b)}};
        },
        held);
}

/// The narrow phase of two shapes at places (centre and rotation, row by row): its distance, and for each feature its
/// kind, gap, number of the body with the point (0 or 1), and point or edge. For tests.
std::tuple<double, std::vector<double>> world_look(AnyStepper& held, std::int64_t one, std::int64_t other, Array<1> places, double margin, double inset) {
    return with(held, [&](auto& world) -> std::tuple<double, std::vector<double>> {
        constexpr int d = DIMENSION<decltype(world)>;
        const Shape<d>&A = world.shapes[one], &B = world.shapes[other];
        Reader read{places.data()};
        PlacedShape<d> a, b;
        for (PlacedShape<d>* placed : {&a, &b}) {
            Placement<d> at;
            read(at.centre, at.R);
            placed->place(placed == &a ? A : B, at);
        }
        std::vector<Feature<d>> found;
        const double apart = NarrowPhase<d>(0, 1, A, B, a, b, margin, inset, found).find();
        Writer write;
        for (const Feature<d>& each : found) {
            const bool first = each.point_body == 0;
            const double gap = first ? gap_of(each, A, B, a.at, b.at) : gap_of(each, B, A, b.at, a.at);
            write(static_cast<int>(each.kind), gap, each.point_body, each.point);
        }
        return {apart, std::move(write.values)};
    });
}

}  // namespace

std::vector<PyMethodDef> world_functions() {
    return {
        entry<world_new>("world_new"),
        entry<world_half_space>("world_half_space"),
        entry<world_polygon>("world_polygon"),
        entry<world_polyhedron>("world_polyhedron"),
        entry<world_body>("world_body"),
        entry<world_link>("world_link"),
        entry<world_force>("world_force"),
        entry<world_begin>("world_begin"),
        entry<world_tell_pairs>("world_tell_pairs"),
        entry<world_run>("world_run"),
        entry<world_state>("world_state"),
        entry<world_collisions>("world_collisions"),
        entry<world_save>("world_save"),
        entry<world_restore>("world_restore"),
        entry<world_reset_deepest>("world_reset_deepest"),
        entry<world_counts>("world_counts"),
        entry<world_look>("world_look"),
    };
}

}  // namespace rockslip::python
