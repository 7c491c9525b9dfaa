"""Cautions about input that looks like a mistake, in one line each."""

from __future__ import annotations

import math

from solver.excitation.motion import GroundMotion
from solver.excitation.sampled import SampledMotion
from solver.results.endings import motion_end
from solver.scene import BlockSpec, MotionSpec, Scene
from solver.scene.footing import beyond_edge
from solver.scene.time import STEPS_A_PERIOD
from solver.scene.units import G_UNIT

STRONGEST_G = 3.0
"""Peak acceleration of a motion that is worth a second look, g: hardly any on the ground
was as large (3.9 g along the vertical at IWTH25, Iwate-Miyagi 2008)."""

DENSITIES = 10.0, 25_000.0
"""Densities of blocks that are worth no second look, kg/m3: from foam to metals."""

LARGEST_FRICTION = 5.0
"""Coefficient of friction that is worth a second look: beyond all but glue, and in degrees less
than a smooth surface has."""

LARGEST_GRAVITY = 30.0
"""Acceleration of gravity that is worth a second look, m/s2: that of Jupiter is less."""

SOFTEST = 1e6
"""Young's modulus that is worth a second look, Pa: soft rubber has that."""

LONGEST_PERIOD = 20.0
"""Period of a platform that is worth a second look, s."""

LARGEST_DAMPING = 1.0
"""Damping ratio of a platform that is worth a second look: beyond it, it does not swing."""

HEAVIEST_LOAD = 50.0
"""Mass of all blocks over that of their platform that is worth a second look."""

COARSEST_RECORD = 0.1
"""Time between samples of a recorded motion that is worth a second look, s: accelerographs take
fifty or more a second."""

FEWEST_STEPS_A_PERIOD = 10.0
"""Steps in a period of the ground's motion, or in a quarter period of a rocking block, fewest that
see it."""


def cautions_of_input(scene: Scene, ground: GroundMotion) -> list[str]:
    """Cautions about input that looks like a mistake, which runs repeat."""
    return [
        *_strange_densities(scene),
        *_soft_materials(scene),
        *_strange_platforms(scene),
        *_strange_friction(scene),
        *_falling_at_once(scene),
        *_strange_gravity(scene),
        *_lost_from_the_start(scene),
        *_strong_motions(scene, ground),
        *_coarse_records(scene, ground),
        *_still_motions(scene, ground),
        *_motions_beyond_the_end(scene, ground),
        *_unequal_ends(scene, ground),
        *_blind_steps(scene),
        *_points_beside_edges(scene),
        *_missing_rows(scene),
    ]


def _strong_motions(scene: Scene, ground: GroundMotion) -> list[str]:
    """Motions with accelerations that no ground has had."""
    found = []
    for where, part in zip(scene.directions, ground.parts, strict=True):
        if part is None or part.peak <= STRONGEST_G * G_UNIT:
            continue
        at, suspects = "", "amplitude_g, which is in g"
        if isinstance(part, SampledMotion):
            at = f", in {part.largest}" if part.largest else ""
            suspects = "its units, its scale and its decimal points"
        found.append(
            f"{where} reaches {part.peak / G_UNIT:.4g} g{at}: more than {STRONGEST_G:g} g has "
            f"hardly been recorded; look at {suspects}"
        )
    return found


def _strange_densities(scene: Scene) -> list[str]:
    """Blocks lighter than foam or heavier than metals."""
    low, high = DENSITIES
    return [
        f"{block.name} weighs {block.shape.density:.3g} kg/m3: look at its lengths, in m, and at "
        "its mass, in kg"
        for block in scene.blocks
        if not low <= block.shape.density <= high
    ]


def _soft_materials(scene: Scene) -> list[str]:
    """Bodies softer than rubber, and foundations lighter than foam or heavier than metals."""
    plane = scene.material_plane
    bodies = {each.name: each.material(plane) for each in scene.blocks if each.model == "elastic"}
    below = scene.foundation.pressed_material(plane, scene.carried_mass)
    if below is not None:
        bodies["the foundation"] = below
    found = [
        f"{name} has a Young's modulus of {material.young:.3g} Pa, that of rubber or less: look at "
        "its unit"
        for name, material in bodies.items()
        if material.young < SOFTEST
    ]
    low, high = DENSITIES
    if below is not None and not low <= below.density <= high:
        found.append(f"the foundation weighs {below.density:.3g} kg/m3: look at the unit of that")
    return found


def _strange_platforms(scene: Scene) -> list[str]:
    """Platforms on springs that are much lighter than what they carry, slow, or do not swing."""
    if not scene.has_platform:
        return []
    platform, found = scene.platform(), []
    if scene.carried_mass > HEAVIEST_LOAD * platform.mass:
        found.append(
            f"the platform has {platform.mass:.4g} kg and carries {scene.carried_mass:.4g} kg: "
            "look at the unit of its mass"
        )
    if platform.period > LONGEST_PERIOD:
        found.append(f"the platform has a period of {platform.period:.4g} s: look at its unit")
    if platform.damping_ratio > LARGEST_DAMPING:
        found.append(
            f"the platform has a damping ratio of {platform.damping_ratio:g}, at 1 of which it no "
            "longer swings: a part of 1 is meant, not percent"
        )
    return found


def _lost_from_the_start(scene: Scene) -> list[str]:
    """Blocks that nothing can keep where they start: over an edge, or leaning too far."""
    found = []
    for block in scene.blocks:
        if beyond_edge(scene, block):
            found.append(f"{block.name} starts with its centre beyond the edge of {block.on}")
        most = block.shape.slenderness
        if scene.dimension == 2 and not scene.gravity_tilt_deg and abs(block.tilt) >= most:
            found.append(
                f"{block.name} starts at {block.tilt_deg:g} degrees, and falls over from "
                f"{math.degrees(most):.4g} on"
            )
    return found


def _coarse_records(scene: Scene, ground: GroundMotion) -> list[str]:
    """Records whose samples are so far apart that their times are hardly in seconds."""
    sampled = dict(zip(scene.directions, ground.parts, strict=True))
    found = []
    for where, spec in scene.motions:
        part = sampled[where]
        if spec.kind != "record" or not isinstance(part, SampledMotion):
            continue
        if (part.step or 0.0) > COARSEST_RECORD:
            found.append(
                f"the samples of {where} are {part.step:g} s apart, as in no record: look at the "
                "unit of its times"
            )
    return found


def _motions_beyond_the_end(scene: Scene, ground: GroundMotion) -> list[str]:
    """Motions of which a run sees nothing, or not all."""
    end = scene.time.end * (1 + 1e-9)
    late = [(where, getattr(spec, "start", 0.0)) for where, spec in scene.motions]
    found = [
        f"{where} begins at {start:g} s, after the run ends at {scene.time.end:g} s"
        for where, start in late
        if start > end
    ]
    stop = motion_end(ground)
    if not found and math.isfinite(stop) and stop > end:
        found.append(f"the run ends at {scene.time.end:g} s, before its motion does at {stop:g} s")
    return found


def _unequal_ends(scene: Scene, ground: GroundMotion) -> list[str]:
    """Components given by samples of which one ends before another."""
    parts = zip(scene.directions, ground.parts, strict=True)
    ends = {where: part.stop for where, part in parts if isinstance(part, SampledMotion)}
    if len({round(end, 6) for end in ends.values()}) < 2:
        return []
    words = ", ".join(f"{end:g} s ({where})" for where, end in ends.items())
    return [f"components of the motion end at {words}: each is zero after its end"]


def _blind_steps(scene: Scene) -> list[str]:
    """Steps too long to see the motion of the ground, or the block's own, and what others cost."""
    span = scene.time
    longest = span.largest if span.adaptive else span.step
    if longest is None:
        return []
    seen = [(spec.shortest_period, _shown_motion(where, spec)) for where, spec in scene.motions]
    seen += [(_quarter_period(scene, block), f"a swing of {block.name}") for block in scene.blocks]
    shortest, what = min(seen)
    # The longest of adaptive steps is taken only where the error allows it.
    fewest = FEWEST_STEPS_A_PERIOD / (2 if span.adaptive else 1)
    if longest <= shortest / fewest * (1 + 1e-9):
        return []
    better = float(f"{shortest / STEPS_A_PERIOD:.1g}")
    key = "time.largest" if span.adaptive else "time.step"
    return [
        f"steps of {longest:g} s, {shortest / longest:.2g} in the {shortest:.3g} s of {what}, do "
        f"not see it: {key} = {better:g} does, in {span.end / better:.0f} steps instead of "
        f"{span.end / longest:.0f}"
    ]


def _shown_motion(where: str, spec: MotionSpec) -> str:
    """What of a motion has its shortest period, in words."""
    if spec.kind in ("record", "table", "synthetic"):
        return f"the fastest part of [{where}] that moves blocks"
    return f"[{where}], kind = {spec.kind}"


def _quarter_period(scene: Scene, block: BlockSpec) -> float:
    """From a peak to the next impact, s; infinite where nothing rights the block.

    Of a released block Housner's acosh(1/(1 - theta/alpha))/p, of one that stands 1/p.
    """
    p, share = block.shape.frequency(scene.gravity), abs(block.tilt) / block.shape.slenderness
    if p <= 0:
        return math.inf
    return math.acosh(1 / (1 - share)) / p if 0 < share < 1 else 1 / p


def _strange_friction(scene: Scene) -> list[str]:
    """Coefficients of friction that are rather angles or percentages."""
    coefficients = [(block.name, scene.friction_of(block).static) for block in scene.blocks]
    return [
        f"{name} has a friction of {static:g}: a coefficient is meant, neither degrees nor percent"
        for name, static in coefficients
        if static > LARGEST_FRICTION
    ]


def _falling_at_once(scene: Scene) -> list[str]:
    """Elastic blocks whose friction falls from its static to its dynamic value at once."""
    found = []
    for block in scene.blocks:
        law = scene.friction_of(block)
        if block.model == "elastic" and law.static != law.dynamic and not law.decays:
            found.append(
                f"friction of {block.name} falls from {law.static:g} to {law.dynamic:g} at once: "
                "an elastic block breaks loose point by point then, and how far it slips depends "
                "on mesh, step and damping; the paper avoids it, too: give decay"
            )
    return found


def _strange_gravity(scene: Scene) -> list[str]:
    """Gravity that is rather in another unit."""
    if scene.gravity <= LARGEST_GRAVITY:
        return []
    return [f"gravity is {scene.gravity:g} m/s2, {scene.gravity / G_UNIT:.3g} g: look at its unit"]


def _still_motions(scene: Scene, ground: GroundMotion) -> list[str]:
    """Motions that do not move."""
    return [
        f"{where} does not move: all its accelerations are 0"
        for where, part in zip(scene.directions, ground.parts, strict=True)
        if part is not None and part.peak == 0.0
    ]


def _points_beside_edges(scene: Scene) -> list[str]:
    """Blocks that start on an edge where none of their contact points is."""
    if scene.contact.points != "gauss":
        return []
    return [
        f'{block.name} starts on an edge, where contact.points = "gauss" has no point: it falls '
        'onto the first one and bounces; "nodes" has points there'
        for block in scene.blocks
        if block.model == "elastic" and block.tilt != 0
    ]


def _missing_rows(scene: Scene) -> list[str]:
    """Histories without the rows of most steps."""
    every = scene.output.history_every
    if every == 1:
        return []
    return [
        f"the history keeps one step in {every}; peaks, impacts and floor spectra are read from it "
        "and may be missed: output.history_every = 1 keeps every step"
    ]
