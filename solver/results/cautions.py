"""Cautions: what a scene or a run should not be trusted for, in one line each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from solver.excitation.motion import GroundMotion
from solver.excitation.sampled import SampledMotion
from solver.results.endings import motion_end
from solver.scene import BlockSpec, MotionSpec, Scene
from solver.scene.motion import G_UNIT
from solver.scene.time import STEPS_A_PERIOD, TOLERANCE

if TYPE_CHECKING:
    from geometry.solid import Solid

STRONGEST_G = 3.0
"""Peak acceleration of a motion above which its unit is in doubt, g: hardly any on the ground was
as large (3.9 g along the vertical at IWTH25, Iwate-Miyagi 2008)."""

DENSITIES = 10.0, 25_000.0
"""Densities outside of which units are in doubt, kg/m3: from foam to metals."""

LARGEST_EXCESS = 0.05
"""Part of its volume by which contacts may see a body larger than it is."""

SOFTEST = 1e6
"""Young's modulus below which its unit is in doubt, Pa: soft rubber has that."""

LARGEST_GRAVITY = 30.0
"""Gravity above which its unit is in doubt, m/s2: that of Jupiter is less."""

FEWEST_STEPS_A_PERIOD = 10.0
"""Steps in a period of the ground's motion, or in a quarter period of a rocking block, fewest that
follow it."""

UNRESOLVED = 0.2
"""Part of what impacts lose that may go to time integration and undamped contact."""

NOTABLE = 0.02
"""Losses of impacts below this part of the scale of the energy balance are not judged."""

STEPS_A_CROSSING = 10.0
"""Steps in which sound crosses the height of a block, fewest that resolve its impacts."""

STEPS_A_LANDING = 20.0
"""Steps in a landing on a bed with dashpots, fewest that resolve it."""

MOST_COARSE = 0.01
"""Part of the steps that may miss the tolerance for want of shorter ones."""

FASTER = 1.02
"""Ratio of angular velocities beyond which an impact gave a block energy of something else."""


def cautions_of_input(scene: Scene, ground: GroundMotion) -> list[str]:
    """Cautions about input that looks like a mistake, which runs repeat."""
    return [
        *_densities(scene),
        *_hulls(scene),
        *_hollows(scene),
        *_soft_materials(scene),
        *_gravity(scene),
        *_friction_jumps(scene),
        *_strong_motions(scene, ground),
        *_motions_beyond_the_end(scene, ground),
        *_undersampled_motion(scene),
        *_undersampled_links(scene),
        *_forces_beyond_the_end(scene),
    ]


def _densities(scene: Scene) -> Iterator[str]:
    """Bodies lighter than foam or heavier than metals."""
    weighed = [
        (block.name, block.shape.density, "its lengths, in m, and at its mass, in kg")
        for block in scene.blocks
    ]
    weighed += [
        (f"part {number} of {block.name}", part.density, "the unit of that")
        for block in scene.blocks
        for number, part in enumerate(block.parts, 1)
    ]
    below = scene.foundation.pressed_material(scene.material_plane, scene.carried_mass)
    if below is not None:
        weighed.append(("the foundation", below.density, "the unit of that"))
    low, high = DENSITIES
    for name, density, suspects in weighed:
        if not low <= density <= high:
            yield f"{name} weighs {density:.3g} kg/m3: look at {suspects}"


def _hulls(scene: Scene) -> Iterator[str]:
    """Surfaces of files that contacts do not see as they are."""
    for block in scene.blocks:
        solid, spec = block.shape.solid, block.given_shape
        if solid is None or spec is None:
            continue
        meshed = block.model == "elastic"
        excess = _excess_of_hull(solid) if meshed else solid.hull_excess
        if not excess > LARGEST_EXCESS:
            continue
        larger = f"by {percent(excess)} % of its volume"
        if meshed:
            seen = f"where its surface is on its convex hull, which is larger {larger}: "
            seen += "nothing touches it where it is hollow"
        else:
            what = "its convex hull" if len(solid.parts) == 1 else "convex parts"
            seen = f"larger than its surface {larger}, as {what}: "
            seen += "others touch it where it is hollow"
        parts = "; give parts as shape.union" if spec.kind == "file" else ""
        yield f"contacts see {block.name} {seen}{parts}"


def _excess_of_hull(solid: Solid) -> float:
    """Volume of the hull of a surface over its own, minus 1; 0 without a surface."""
    if solid.surface is None:
        return 0.0
    from geometry.shapes import of_surface  # numpy and more

    return of_surface(solid.surface, 1.0, parts="hull").hull_excess


def _hollows(scene: Scene) -> Iterator[str]:
    """Blocks that stand on others, meshed, which meet by their hulls though they are not convex."""
    if scene.is_rigid:
        return
    from solver.scene.places import standing_part  # numpy and more

    known = {block.name: block for block in scene.blocks}
    placed = scene.poses()
    for upper in scene.blocks:
        for lower in (known[name] for name in upper.carriers if name in known):
            if standing_part(upper, lower, placed, scene.dimension) is not None:
                continue
            narrow = lower.width < upper.width or lower.thickness < upper.thickness
            for block, counts in ((lower, True), (upper, narrow)):
                solid = block.shape.solid
                if counts and solid is not None and len(solid.parts) > 1:
                    yield (
                        f"{upper.name} and {lower.name}, which carries it, meet by the faces of"
                        f" their convex hulls, beside a meshed body: they do not touch within the"
                        f" hollows of {block.name}"
                    )


def percent(part: float) -> str:
    """A part in percent, two digits or more."""
    return f"{100 * part:.2g}" if part < 1 else f"{100 * part:.0f}"


def _soft_materials(scene: Scene) -> Iterator[str]:
    """Bodies softer than rubber."""
    plane = scene.material_plane
    bodies = {each.name: each.material(plane) for each in _elastic(scene)}
    below = scene.foundation.pressed_material(plane, scene.carried_mass)
    if below is not None:
        bodies["the foundation"] = below
    for name, material in bodies.items():
        if material.young < SOFTEST:
            modulus = f"a Young's modulus of {material.young:.3g} Pa"
            yield f"{name} has {modulus}, that of rubber or less: look at its unit"


def _gravity(scene: Scene) -> Iterator[str]:
    """Gravity that is rather in another unit."""
    if scene.gravity > LARGEST_GRAVITY:
        yield f"gravity is {scene.gravity:g} m/s2, {scene.gravity / G_UNIT:.3g} g: look at its unit"


def _friction_jumps(scene: Scene) -> Iterator[str]:
    """Elastic blocks whose friction falls from its static to its dynamic value at once."""
    for block in _elastic(scene):
        law = scene.friction_of(block)
        if law.static != law.dynamic and not law.decays:
            yield (
                f"friction of {block.name} falls from {law.static:g} to {law.dynamic:g} at once: "
                "an elastic block breaks loose point by point then, and how far it slips depends "
                "on mesh, step and damping; the paper avoids it, too: give decay"
            )


def _strong_motions(scene: Scene, ground: GroundMotion) -> Iterator[str]:
    """Motions with accelerations that no ground has had."""
    for where, part in zip(scene.directions, ground.parts, strict=True):
        if part is None or part.peak <= STRONGEST_G * G_UNIT:
            continue
        at, suspects = "", "amplitude_g, which is in g"
        if isinstance(part, SampledMotion):
            at = f", in {part.largest}" if part.largest else ""
            suspects = "its units, its scale and its decimal points"
        yield (
            f"{where} reaches {part.peak / G_UNIT:.4g} g{at}: more than {STRONGEST_G:g} g has "
            f"hardly been recorded; look at {suspects}"
        )


def _motions_beyond_the_end(scene: Scene, ground: GroundMotion) -> Iterator[str]:
    """Motions that begin after the end of a run, or end after it."""
    end = scene.time.end * (1 + 1e-9)
    starts = {where: getattr(spec, "start", 0.0) for where, spec in scene.motions}
    late = {where: start for where, start in starts.items() if start > end}
    for where, start in late.items():
        yield f"{where} begins at {start:g} s, after the run ends at {scene.time.end:g} s"
    stop = motion_end(ground)
    if not late and math.isfinite(stop) and stop > end:
        yield f"the run ends at {scene.time.end:g} s, before its motion does at {stop:g} s"


def _undersampled_motion(scene: Scene) -> Iterator[str]:
    """Steps too long to follow the motion of the ground or of a block, and what others cost."""
    span = scene.time
    longest = span.largest if span.adaptive else span.step
    if longest is None:
        return
    seen = [(spec.shortest_period, _shown_motion(where, spec)) for where, spec in scene.motions]
    seen += [(_quarter_period(scene, block), f"a swing of {block.name}") for block in scene.blocks]
    shortest, what = min(seen)
    # The longest of adaptive steps is taken only where the error allows it.
    fewest = FEWEST_STEPS_A_PERIOD / (2 if span.adaptive else 1)
    if longest > shortest / fewest * (1 + 1e-9):
        better = float(f"{shortest / STEPS_A_PERIOD:.1g}")
        key = "time.largest" if span.adaptive else "time.step"
        yield (
            f"steps of {longest:g} s, {shortest / longest:.2g} in the {shortest:.3g} s of {what}, "
            f"do not see it: {key} = {better:g} does, in {span.end / better:.0f} steps instead of "
            f"{span.end / longest:.0f}"
        )


def _undersampled_links(scene: Scene) -> Iterator[str]:
    """The stiffest link, where given steps are too long to follow what swings on it."""
    if not scene.links or scene.time.adaptive:
        return
    link = min(scene.links, key=scene.link_period)
    period, step = scene.link_period(link), scene.time.step
    if step > period / FEWEST_STEPS_A_PERIOD * (1 + 1e-9):
        better = float(f"{period / STEPS_A_PERIOD:.1g}")
        yield (
            f"steps of {step:g} s, {period / step:.2g} in the {period:.3g} s in which its bodies "
            f"swing on {link.name}, do not follow that: its forces are means, and time.step = "
            f"{better:g} shows them"
        )


def _forces_beyond_the_end(scene: Scene) -> Iterator[str]:
    """Forces that go on changing after the end of a run."""
    end = f"the run ends at {scene.time.end:g} s"
    for force in scene.forces:
        if force.settled > scene.time.end * (1 + 1e-9):
            yield f"{end}, before {force.name} is what it becomes at {force.settled:g} s"


def _shown_motion(where: str, spec: MotionSpec) -> str:
    """The part of a motion that has its shortest period, in words."""
    if spec.kind in ("record", "table", "synthetic"):
        return f"the fastest part of [{where}] that moves blocks"
    return f"[{where}], kind = {spec.kind}"


def _quarter_period(scene: Scene, block: BlockSpec) -> float:
    """From a peak to the next impact, s; infinite where nothing rights the block.

    Of a released block Housner's acosh(1/(1 - theta/alpha))/p, of one that stands 1/p.
    """
    side = 0 if not block.tilt else 1 if block.tilt > 0 else -1
    p = block.shape.frequency(scene.gravity, side)
    alpha = block.shape.slenderness(side)
    if p <= 0 or alpha <= 0:  # it stands on a tip
        return math.inf
    share = abs(block.tilt) / alpha
    return math.acosh(1 / (1 - share)) / p if 0 < share < 1 else 1 / p


def impact_losses(loss: Mapping[str, float]) -> dict[str, float]:
    """The losses of impacts among those of a run, such as `damping_J`: all but friction, J."""
    return {name: value for name, value in loss.items() if name != "friction_J"}


LOSS_ROUND_OFF = 1e-12
"""A loss of no more than this part of the scale of a run's energies is round-off."""


def loss_shares(loss: Mapping[str, float], scale: float) -> dict[str, float]:
    """Part of the whole loss that each cause has; empty where nothing beyond round-off was lost.

    The scale is that of the run's energies, J.
    """
    whole = sum(loss.values())
    if abs(whole) <= LOSS_ROUND_OFF * scale:
        return {}
    return {name.removesuffix("_J"): value / whole for name, value in loss.items()}


def unresolved_share(loss: Mapping[str, float]) -> float:
    """Part of what impacts lost that went to time integration and undamped contact."""
    lost = impact_losses(loss)
    whole = sum(lost.values())
    return (lost["contact_J"] + lost["numerical_J"]) / whole if whole > 0 else 0.0


def _crossing_time(block: BlockSpec) -> float:
    """Time in which sound crosses the height of an elastic block, s."""
    return block.height / block.material("stress").wave_speed


def cautions_of_run(scene: Scene, loss: Mapping[str, float], scale: float) -> Iterator[str]:
    """Cautions about a run of meshed bodies, by its losses and the scale of its balance, J.

    Where nothing deforms, contact takes what the law of impact gives, whatever the steps.
    """
    share = unresolved_share(loss)
    lost = sum(impact_losses(loss).values())
    deforms = scene.foundation.is_meshed or _elastic(scene)
    if not deforms or share <= UNRESOLVED or not lost > NOTABLE * scale:
        return
    by_law = ", ".join(block.name for block in scene.blocks if _lands_by_law(scene, block))
    besides = f" (or, for {by_law}, to the law of impact)" if by_law else ""
    yield (
        f"{100 * share:.0f} % of what impacts lost went to time integration and undamped contact"
        f"{besides}, so that step and mesh decide how long blocks rock{_remedy(scene)}"
    )


def _lands_by_law(scene: Scene, block: BlockSpec) -> bool:
    """True if neither a block nor its carrier deforms."""
    carrier = scene.carrier_of(block)
    firm = not scene.foundation.is_meshed if carrier is None else carrier.model == "rigid"
    return block.model == "rigid" and firm


def cautions_of_steps(scene: Scene, cost: Mapping[str, Any]) -> Iterator[str]:
    """Cautions about steps that are longer than the tolerance requires, by their counts."""
    coarse, steps = cost.get("coarse_steps", 0), cost.get("steps", 0)
    if coarse > MOST_COARSE * steps:
        yield (
            f"{coarse} of {steps} steps miss time.tolerance, since time.smallest = "
            f"{scene.time.smallest:g} s allows none that are shorter"
        )


def cautions_of_end(scene: Scene, status: str, reason: str) -> Iterator[str]:
    """Cautions about a run that a block ended, which fell, or one of several, which overturned."""
    if status != "completed" or not reason:
        return
    if len(scene.blocks) > 1:
        end = f"the run ends before {scene.time.end:g} s"
        yield f"{end} ({reason}): other blocks are known up to then"
    elif " fell " in reason:
        yield f"{reason}: nothing catches it, and the run ends there"


def cautions_of_impacts(scene: Scene, blocks: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    """Cautions about impacts from which a block came faster, by the entries of a summary.

    On a foundation that deforms, but does not move as a whole.
    """
    if not scene.foundation.is_meshed or scene.carrier_moves:
        return
    for block in scene.blocks:
        impacts = blocks[block.name]["impacts"] if block.carrier == "foundation" else []
        faster = [i for i in impacts if i.get("ratio", 0.0) > FASTER]
        if faster:
            first = faster[0]
            yield (
                f"{block.name} comes from its impact at {first['time_s']:.4g} s "
                f"{first['ratio']:.3g} times as fast as it met it: the foundation vibrates, "
                "and step, mesh and its damping decide what follows"
            )


def cautions_of_scene(scene: Scene, ground: GroundMotion) -> Iterator[str]:
    """Cautions that no run is needed for."""
    yield from cautions_of_input(scene, ground)
    yield from _undamped_foundation(scene)
    if not _elastic(scene):
        return
    if _overruled(scene):
        yield "[damping] applies to no body: each block has its own damping"
    crossing = min(map(_crossing_time, _elastic(scene)))
    resolving = min(_resolving_step(scene, block) for block in _elastic(scene))
    if not scene.time.adaptive and scene.time.step > resolving:
        yield (
            f"sound crosses a block in {crossing:.2g} s, so that steps of {scene.time.step:g} s do "
            f"not resolve its impacts and decide what these lose{_remedy(scene)}"
        )
    elif _undamped(scene):
        yield (
            "nothing damps the blocks, so that what one impact shakes meets the next one and no "
            f"step resolves what that loses{_remedy(scene)}"
        )


def _resolving_step(scene: Scene, block: BlockSpec) -> float:
    """Longest step that resolves the impacts of an elastic block, s.

    On a soft bed with dashpots a block moves as a whole and its waves lose little.
    """
    crossing = _crossing_time(block) / STEPS_A_CROSSING
    bed = scene.bed_of(block)
    if bed is None or scene.contact.damping == 0:
        return crossing
    return max(crossing, bed.landing / STEPS_A_LANDING)


def _elastic(scene: Scene) -> list[BlockSpec]:
    """The elastic blocks of a scene."""
    return [block for block in scene.blocks if block.model == "elastic"]


def _overruled(scene: Scene) -> bool:
    """True if no body has the damping of `[damping]`, as in the copy of a scene without one."""
    own = all(block.damping is not None for block in _elastic(scene))
    return scene.damping is not None and own and not scene.foundation.is_meshed


def _undamped_foundation(scene: Scene) -> Iterator[str]:
    """A meshed foundation whose vibration lasts from one impact on it to the next."""
    if scene.foundation_vibrates and not scene.contact.damping:
        yield (
            "nothing damps the foundation, so that what one impact shakes in it meets the next one "
            "and decides what that loses: give foundation.damping.stiffness"
        )


def _undamped(scene: Scene) -> list[BlockSpec]:
    """The elastic blocks whose strain nothing damps, nor their contact."""
    if scene.contact.damping > 0:
        return []
    damping = [(block, scene.damping_of(block)) for block in _elastic(scene)]
    return [block for block, own in damping if own is None or own.stiffness == 0]


def _remedy(scene: Scene) -> str:
    """The change that would help, in words."""
    changes = []
    if not scene.time.adaptive:
        changes.append("leave out time.step, so that steps are adaptive")
    elif (scene.time.tolerance or 0.0) > TOLERANCE:
        changes.append(f"leave out time.tolerance, which is {TOLERANCE:g} then")
    if undamped := _undamped(scene):
        most = max(scene.default_damping(block).stiffness for block in undamped)
        changes.append(f"give damping.stiffness, by default {most:.3g} s")
    return f": {', and '.join(changes)}" if changes else ""
