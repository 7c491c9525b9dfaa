"""Description of a scene, without solving it: derived numbers, expected mode, size."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from geometry.block import SIDES, Block
from geometry.shapes import chord_error
from solver.bodies.memory import solver_in_words
from solver.errors import EnvironmentTrouble
from solver.excitation.forces import whole_force
from solver.excitation.kinds import BaseMotion
from solver.excitation.motion import GroundMotion, read_ground
from solver.excitation.pulses import Pulse
from solver.excitation.sampled import SampledMotion
from solver.excitation.spectrum import (
    arias_intensity,
    longest_spacing,
    peak_ground,
    response_spectrum,
    significant_duration,
)
from solver.info import table
from solver.reference.initiation import expected_mode, has_expected_mode
from solver.results.cautions import cautions_of_scene, percent
from solver.scene import BlockSpec, Scene
from solver.scene.damping import DampingSpec
from solver.scene.motion import G_UNIT
from solver.scene.places import link_ends
from solver.scene.time import TimeSpec

Lines = Iterable[tuple[str, str]]
"""Names and texts."""

MOST_FRICTION = 1.0
"""Coefficient of friction up to which flutter is looked for, unless a block has more."""

MOST_LINEARISED = 50_000
"""Unknowns of a block up to which its modes are computed, which takes ten seconds then."""


SPECTRUM_PERIODS = (0.1, 0.2, 0.5, 1.0, 2.0, 4.0)
"""Periods of the spectrum of a motion, s."""


def describe(scene: Scene) -> str:
    """Describe a scene: derived numbers, expected mode, size of the mesh, steps."""
    return table([*_lines(scene)])


def _lines(scene: Scene) -> Lines:
    """All lines of the description."""
    yield "scene", scene.title or "without a title"
    for block in scene.blocks:
        yield from _block_numbers(block, scene)
    ground = read_ground(scene)
    yield from _foundation(scene, ground)
    yield from _frictions(scene)
    yield from _pairs(scene)
    yield from _links(scene)
    yield from _forces(scene)
    yield from _beds(scene)
    yield from _motions(scene, ground)
    if has_expected_mode(scene):
        yield "expected mode", f"{expected_mode(scene, ground)} (rigid block; Shenton 1996)"
    for block in scene.blocks:
        yield f"mesh{_of(block, scene)}", block.mesh_in_words
        if block.model == "elastic":
            mesh, d = block.mesh, scene.dimension
            yield "  linear solver", solver_in_words(d * mesh.nodes, mesh.nodes_below, d)
    yield "time", _steps(scene.time)
    for text in cautions_of_scene(scene, ground):
        yield "caution", text


def _of(block: BlockSpec, scene: Scene) -> str:
    """The name of a block behind that of a line, where there are several."""
    return f" of {block.name}" if len(scene.blocks) > 1 else ""


def _steps(span: TimeSpec) -> str:
    """The steps of a run, in words."""
    if span.adaptive:
        return f"adaptive steps of at most {span.largest:g} s to {span.end:g} s"
    steps = math.ceil(span.end / span.step * (1 - 1e-12))
    return f"{steps} steps of {span.step:g} s to {span.end:g} s"


def _block_numbers(block: BlockSpec, scene: Scene) -> Lines:
    """Numbers of rigid-body rocking."""
    shape = block.shape
    tilt = f", released from {block.tilt_deg:g} degrees" if block.tilt_deg else ""
    if tilt and block.tilt_direction_deg:
        tilt += f" towards {block.tilt_direction_deg:g} degrees from x"
    on = f", on {' and '.join(block.carriers)}" if block.carriers != ("foundation",) else ""
    if block.position is not None:
        on = f", with its centre at ({', '.join(f'{part:g}' for part in block.position)}) m"
    mean = "" if shape.is_even else "in the mean, "
    yield block.name, f"{block.width:g} x {block.height:g} x {block.thickness:g} m{on}{tilt}"
    yield from _outline(block, shape)
    yield "  mass", f"{shape.mass:.6g} kg ({mean}{shape.density:.6g} kg/m3)"
    if not shape.is_even:
        yield from _uneven(shape, scene.dimension)
    yield from _rocking(block, shape, scene, "")
    if scene.dimension == 3:
        yield from _rocking(block, shape.across((0.0, 1.0)), scene, "y")
        yield from _leaning(block, shape)
    yield from damping_of_block(block, scene)
    if block.model == "elastic":
        yield "  steady sliding", _sliding(block, scene)
    yield from _start(block)


def _outline(block: BlockSpec, shape: Block) -> Lines:
    """What a shape is made of, or the feet of a box; nothing of other boxes."""
    solid, spec = shape.solid, block.given_shape
    if solid is None:
        return
    if block.container is not None:
        model = "" if block.scale == 1.0 else f" at a scale of {block.scale:g}"
        yield "  container", f"{block.container}{model}, on its corner castings"
        return
    if spec is None:
        low, high = shape.base or (0.0, 0.0)
        tall = f"{shape.height:g} m high with them, {high - low:g} m over their outer edges"
        yield "  feet", f"{shape.feet}: {tall} along x"
        return
    flat, count = solid.dimension == 2, len(solid.parts)
    facets = sum(len(part.faces) for part in solid.parts)
    parts = f"{count} convex parts" if count > 1 else "convex"
    if count == 1 and not solid.is_convex:
        parts = "a convex hull"
    yield "  shape", f"{spec.kind}: {parts}, {facets} {'sides' if flat else 'facets'}"
    for number, each in enumerate((spec, *spec.union)):
        radius = each.radius(block.width)
        if radius is not None:
            of = f" part {number}" if number else ""
            sides = each.regular or each.sides
            off = 1e3 * chord_error(radius, sides)
            yield f"  round{of}", f"{sides} facets, within the circle by at most {off:.3g} mm"
    if (surface := solid.surface) is not None:
        more = solid.hull_excess
        how = "convex hull" if count == 1 else parts
        if block.model == "elastic":
            how = "convex hull where its mesh has it"
        text = f"{len(surface.triangles)} triangles; contacts see its {how}, "
        text += f"{percent(abs(more))} % {'larger' if more >= 0 else 'smaller'}"
        if solid.coarse:
            text += f", without corners of less than {1e3 * solid.coarse:.3g} mm"
        yield "  surface", text


def _uneven(shape: Block, dimension: int) -> Lines:
    """Centre of mass and inertia of a block whose mass is not spread evenly."""
    centre = ", ".join(f"{part:.5g}" for part in shape.centre_of_mass(dimension))
    yield "  centre of mass", f"({centre}) m from the middle of the bottom"
    if dimension == 2:
        yield "  inertia", f"{shape.rotary_inertia:.6g} kg m2 about it"
        return
    (x, xy, xz), (_, y, yz), (_, _, z) = shape.inertia_tensor
    text = f"{x:.6g} {y:.6g} {z:.6g} kg m2 about it"
    if any((xy, xz, yz)):
        text += f", xy {xy:.4g}, xz {xz:.4g}, yz {yz:.4g}"
    yield "  inertia", text


def _leaning(block: BlockSpec, shape: Block) -> Lines:
    """The slenderness in the direction of a tilt between the axes: there it turns about no edge.

    A box stands on one corner there, so that radius, frequency and restitution of an edge are none.
    """
    way = math.cos(block.tilt_direction), math.sin(block.tilt_direction)
    if block.tilt and min(map(abs, way)) >= 1e-9:
        alpha = shape.across(way).slenderness(1 if block.tilt > 0 else -1)
        name = f"  slenderness at {block.tilt_direction_deg:g} degrees"
        yield name, f"{alpha:.5f} rad = {math.degrees(alpha):.3f} degrees"


def _rocking(block: BlockSpec, shape: Block, scene: Scene, axis: str) -> Lines:
    """Numbers of rocking along an axis, those of both edges where they differ; "" is x.

    The shape is the block as it stands along that axis.
    """
    down, along = -scene.gravity_vector[-1], scene.gravity_vector[0] if not axis else 0.0
    beside = f" along {axis}" if axis else ""
    sides = SIDES if shape.centre is not None and shape.centre[0] else (0,)
    for side in sides:
        of = f" towards {'-+'[side > 0]}{axis or 'x'}" if side else beside
        alpha = shape.slenderness(side)
        if not axis or side:
            name = "half diagonal R" if shape.centre is None else "radius R"
            yield f"  {name}{of}", f"{shape.radius(side):.4f} m"
        name = f"  slenderness{'' if axis else ' alpha'}{of}"
        yield name, f"{alpha:.5f} rad = {math.degrees(alpha):.3f} degrees"
        if down > 0:
            yield f"  frequency p{of}", f"{shape.frequency(down, side):.4f} 1/s"
            yield f"  uplift{of} at", f"{_uplift(shape, scene, along, side):.4f} g"
        on = f" on the edge at {'-+'[side > 0]}{axis or 'x'}" if side else beside
        yield f"  restitution{on}", _restitution(block, shape, scene, side)


def _restitution(block: BlockSpec, shape: Block, scene: Scene, side: int) -> str:
    """Part of its angular velocity that a rigid block keeps at an impact, and the source of it."""
    ratio, source = shape.restitution(side), "Housner 1963"
    if not shape.is_even:
        source = "angular momentum about that edge" if side else "angular momentum about the edge"
    if scene.has_platform and len(scene.blocks) == 1:
        ratio = shape.restitution(side, shape.mass / (shape.mass + scene.platform().mass))
        number = "R8" if shape.is_even else "R10"
        source = f"on a platform of this mass, ({number}) of docs/reference.md"
    elif not _on_firm_ground(block, scene):
        source += ", on firm ground"
    text = f"{ratio:.4f}" if ratio > 0 else "none, too squat to rock on"
    if restitution := scene.restitution_of(block):
        text = f"{restitution:g}, instead of {text}"
    return f"{text} ({source})"


def _on_firm_ground(block: BlockSpec, scene: Scene) -> bool:
    """True if what carries a block neither moves nor deforms by its impacts."""
    foundation = scene.foundation
    moves = foundation.is_meshed or foundation.moves_as_a_whole
    return block.carriers == ("foundation",) and not moves


def damping_of_block(block: BlockSpec, scene: Scene) -> Lines:
    """Damping of an elastic block, and what it means for its first bending mode."""
    damping = scene.damping_of(block)
    if block.model != "elastic" or damping is None:
        return
    parts = [(damping.mass, "lambda_R", "1/s"), (damping.stiffness, "beta_R", "s")]
    given = [f"{name} {value:.3g} {unit}" for value, name, unit in parts if value]
    if not given:
        yield "  damping", "none"
        return
    frequency = scene.bending_frequency(block)
    ratio = f"{100 * damping.ratio(frequency):.2g} % of critical"
    whose = "its first" if block.is_box else "of the box around it the first"
    mode = f"{frequency / (2 * math.pi):.3g} Hz, {whose} bending mode, held at its base"
    yield "  damping", f"{', '.join(given)}: {ratio} at {mode}"


def _sliding(block: BlockSpec, scene: Scene) -> str:
    """The friction above which the steady sliding of a meshed block flutters, and what holds it."""
    if scene.dimension * block.mesh.nodes > MOST_LINEARISED:
        return f"not linearised: more than {MOST_LINEARISED} unknowns"
    try:
        from solver.build.meshed_body import modes_of_sliding
    except ImportError as error:
        return f"not linearised: {error}"
    modes, damping = modes_of_sliding(scene, block), scene.damping_of(block) or DampingSpec()
    friction = scene.friction_of(block).static
    onset = modes.onset(max(friction, MOST_FRICTION), damping)
    if onset is None:
        return f"does not flutter up to friction {MOST_FRICTION:g}"
    found = modes.flutter(max(friction, onset), damping)
    at = f"at {found.frequency / (2 * math.pi):.3g} Hz"
    if friction <= onset:
        return f"does not flutter at friction {friction:g}; above {onset:.2g} it would, {at}"
    return (
        f"flutters at friction {friction:g}, {at}, growing by {found.growth:.2g} 1/s; "
        f"beta_R = {found.damping:.2g} s would hold it, this damping does up to {onset:.2g}"
    )


def _start(block: BlockSpec) -> Lines:
    """Velocities at the start, where there are any."""
    vectors: dict[str, tuple[tuple[float, ...], str]] = {
        "  velocity": (block.velocity, "m/s"),
        "  angular velocity": (block.spins, "rad/s"),
    }
    for name, (vector, unit) in vectors.items():
        if any(vector):
            yield name, f"{' '.join(f'{number:g}' for number in vector)} {unit}"


def _uplift(shape: Block, scene: Scene, along: float, side: int) -> float:
    """Horizontal acceleration of what carries it over gravity at which a block uplifts.

    It leans to the side; `along` is gravity along its width, m/s2.
    """
    down = -scene.gravity_vector[-1]
    pull = side * along if side else abs(along)
    limit = down * shape.width / shape.height if shape.is_even else down * shape.uplift(side)
    return max(0.0, limit - pull) / scene.gravity


def _foundation(scene: Scene, ground: GroundMotion) -> Lines:
    """Foundation that carries the blocks, with its natural period where it has one."""
    yield from scene.foundation.describe(scene.dimension, scene.carried_mass)
    if scene.has_platform:
        mass, stiffness, damping = platform = scene.platform()
        yield "  mass", f"{mass:.6g} kg (blocks / platform {scene.carried_mass / mass:.4g})"
        yield "  stiffness", f"{stiffness:.6g} N/m"
        ratio = f"{100 * platform.damping_ratio:.3g} % of critical"
        yield "  damping", f"{damping:.6g} N s/m, {ratio}"
        yield "  natural period", f"{platform.period:.4g} s (empty, rigid)"
    if scene.carrier_moves and scene.foundation.needs_mesh_engine:
        yield "  natural period", f"{_computed_period(scene):.4g} s (empty, of the mesh)"
    if scene.foundation.modes is not None:
        yield from _reduction(scene, ground)


def _reduction(scene: Scene, ground: GroundMotion) -> Lines:
    """Modes and nodes that remain of the mesh of a reduced foundation."""
    try:
        from solver.build.foundation import reduction_in_words
    except ImportError as error:
        raise EnvironmentTrouble(f"{error}, which modes need") from error
    names = ("  reduced to", "  modes", "  nodes kept", "  modes left out")
    yield from zip(names, reduction_in_words(scene, ground), strict=True)


def _computed_period(scene: Scene) -> float:
    """Natural period of the meshed foundation alone, s; all that `check` needs dolfinx for."""
    try:
        from solver.build.foundation import natural_period
    except ImportError as error:
        raise EnvironmentTrouble(f"{error}, which the natural period needs") from error
    return natural_period(scene)


def _frictions(scene: Scene) -> Lines:
    """Friction of every block and its carrier; once where all are the same."""
    laws = {block.name: scene.friction_of(block) for block in scene.blocks}
    if len(set(laws.values())) == 1:
        laws = {"": laws.popitem()[1]}
    for name, law in laws.items():
        yield f"friction of {name}" if name else "friction", law.words()


def _pairs(scene: Scene) -> Lines:
    """Pairs of bodies with a law of their own."""
    for pair in scene.pairs:
        friction, restitution = scene.law_between(*pair.between)
        text = f"friction {friction.words()}"
        if scene.is_rigid:
            text += f", restitution {restitution:g}"
        yield f"pair {' and '.join(pair.between)}", text


def _links(scene: Scene) -> Lines:
    """Links: what they join, how stiff they are, where they begin to act, flow and break."""
    placed = scene.poses() if scene.links else {}
    for link in scene.links:
        words = [f"{link.kind} between {' and '.join(link.between)}"]
        if link.is_axial:
            first, second = link_ends(link, placed)
            apart = float(np.linalg.norm(second - first))
            words.append(f"{link.length or apart:.4g} m long")
            if link.length is not None and link.length != apart:
                words.append(f"its ends {apart:.4g} m apart")
        words.append(f"k {link.stiffness:.4g} N/m")
        values = (
            (link.shear_stiffness, "k across", "N/m"),
            (link.damping, "c", "N s/m"),
            (link.gap, "gap", "m"),
            (link.shear_gap, "gap across", "m"),
            (link.preload, "preload", "N"),
            (link.yields, "flows at", "N"),
            (link.strength, "breaks at", "N"),
        )
        words += [f"{name} {value:.4g} {unit}" for value, name, unit in values if value]
        words.append(f"period about {scene.link_period(link):.3g} s")
        yield f"link {link.name}", ", ".join(words)


def _forces(scene: Scene) -> Lines:
    """Forces on blocks: what they are when whole, and how they get there."""
    placed = scene.poses() if scene.forces else {}
    for force in scene.forces:
        shape = next(block.shape for block in scene.blocks if block.name == force.on)
        vector = whole_force(force, placed[force.on], shape)
        words = f"[{', '.join(f'{part + 0.0:.4g}' for part in vector)}] N on {force.on}"
        if force.pressure is not None:
            words += f", {force.pressure:.4g} Pa on its {force.face}"
        if force.ramp is not None:
            words += f", grows from {force.ramp[0]:g} to {force.ramp[1]:g} s"
        if force.table is not None:
            words += f", times a table up to {force.settled:g} s"
        yield f"force {force.name}", words


def _beds(scene: Scene) -> Lines:
    """The bed below each block, and how long landings on it take."""
    for block in scene.blocks:
        bed = scene.bed_of(block)
        if bed is not None:
            text = f"{bed.stiffness:.3g} Pa/m, damped by {100 * scene.contact.damping:g} %"
            yield (
                f"bed{_of(block, scene)}",
                f"{text} of critical; landings take {bed.landing:.2g} s",
            )


def _motions(scene: Scene, ground: GroundMotion) -> Lines:
    """The motion of the ground in each direction."""
    directions = dict(zip(scene.directions, ground.parts, strict=True))
    step = None if scene.time.adaptive else scene.time.step
    for where, _ in scene.motions or (("motion", None),):
        heading, others = describe_motion(directions[where], step)
        name = f"  {where.partition('.')[2]}" if "." in where else "base motion"
        indent = " " * (len(name) - len(name.lstrip()) + 2)
        yield name, heading
        for part, text in others:
            yield f"{indent}{part}", text


def describe_motion(motion: BaseMotion | None, step: float | None) -> tuple[str, Lines]:
    """The peak of a motion in words, and lines: measures of samples, else span and velocity.

    `step` is that of the run, s; None: it is not always the same.
    """
    if motion is None:
        return "none", []
    peak = f"{motion.peak / G_UNIT:.4g} g = {motion.peak:.4g} m/s2"
    if isinstance(motion, SampledMotion):
        measures = _measures(motion)
        read = [("read as", motion.source)] if motion.source else []
        samples = [*read, ("samples", _samples(motion))]
        return f"PGA {peak}", [*samples, *measures, _samples_and_steps(motion, step)]
    if not isinstance(motion, Pulse):
        return f"peak {peak}", []
    velocity = f"up to {motion.peak_velocity:.4g} m/s, {motion.end_velocity:.4g} m/s in the end"
    span = f"{motion.start:.4g} to {motion.start + motion.duration:.4g} s"
    return f"peak {peak}", [("span", span), ("velocity", velocity)]


def _samples(motion: SampledMotion) -> str:
    """Number and spacing of samples."""
    distances = np.diff(motion.time)
    apart = f"{distances.min():.4g} to {distances.max():.4g} s"
    if motion.step is not None:
        apart = f"{motion.step:.6g} s"
    span = f"{motion.duration:.6g} s long, from {motion.time[0]:.4g} s"
    return f"{len(motion.value)}, {apart} apart, {span}"


def _measures(motion: SampledMotion) -> Lines:
    """Peaks, duration, intensity and spectrum; g is 9.81 m/s^2."""
    values, step = motion.evenly_spaced(longest_spacing(SPECTRUM_PERIODS))
    _, _, moved = peak_ground(values, step)
    spectrum = response_spectrum(values, step, SPECTRUM_PERIODS) / G_UNIT
    pairs = [
        f"{period:g} s {value:.4f}"
        for period, value in zip(SPECTRUM_PERIODS, spectrum, strict=True)
    ]
    return [
        ("PGV", f"{motion.peak_velocity:.4f} m/s"),
        ("PGD", f"{moved:.4f} m"),
        ("duration D5-95", f"{significant_duration(values, step):.2f} s"),
        ("Arias intensity", f"{arias_intensity(values, step):.4f} m/s"),
        ("PSA in g, 5 %", ", ".join(pairs)),
    ]


def _samples_and_steps(motion: SampledMotion, step: float | None) -> tuple[str, str]:
    """The steps of the run beside the samples."""
    text = "they take the mean acceleration, no sample is skipped"
    if motion.step is None or step is None:
        return "steps", f"not those of the samples: {text}"
    parts, begin = motion.step / step, float(motion.time[0]) / step
    if abs(parts - round(parts)) > 1e-6 * parts or parts < 0.5:
        return "steps", f"{step:g} s does not divide {motion.step:.6g} s: {text}"
    if abs(begin - round(begin)) > 1e-6:
        return "steps", f"the first sample, at {motion.time[0]:.6g} s, is inside one: {text}"
    return "steps", f"{step:g} s divides {motion.step:.6g} s: {round(parts)} between two samples"
