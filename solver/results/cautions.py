"""What a run, or a scene, should not be trusted for, in one line each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from solver.excitation.motion import GroundMotion
from solver.results.doubtful_input import cautions_of_input
from solver.scene import BlockSpec, Scene
from solver.scene.time import TOLERANCE

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


def impact_losses(loss: Mapping[str, float]) -> dict[str, float]:
    """The losses of impacts among those of a run, such as `damping_J`: all but friction, J."""
    return {name: value for name, value in loss.items() if name != "friction_J"}


def loss_shares(loss: Mapping[str, float]) -> dict[str, float]:
    """Part of the whole loss that each cause has; empty where nothing was lost."""
    whole = sum(loss.values())
    return {name.removesuffix("_J"): value / whole for name, value in loss.items()} if whole else {}


def unresolved_share(loss: Mapping[str, float]) -> float:
    """Part of what impacts lost that went to time integration and undamped contact."""
    lost = impact_losses(loss)
    whole = sum(lost.values())
    return (lost["contact_J"] + lost["numerical_J"]) / whole if whole > 0 else 0.0


def _crossing_time(block: BlockSpec) -> float:
    """Time in which sound crosses the height of an elastic block, s."""
    return block.height / block.material("stress").wave_speed


def cautions_of_run(scene: Scene, loss: Mapping[str, float], scale: float) -> list[str]:
    """Cautions about a run of meshed bodies, by its losses and the scale of its balance, J.

    Where nothing deforms, contact takes what the law of impact says, whatever the steps.
    """
    share = unresolved_share(loss)
    lost = sum(impact_losses(loss).values())
    deforms = scene.foundation.is_meshed or _elastic(scene)
    if not deforms or share <= UNRESOLVED or not lost > NOTABLE * scale:
        return []
    by_law = ", ".join(block.name for block in scene.blocks if _lands_by_law(scene, block))
    besides = f" (or, for {by_law}, to the law of impact)" if by_law else ""
    return [
        f"{100 * share:.0f} % of what impacts lost went to time integration and undamped contact"
        f"{besides}, so that step and mesh decide how long blocks rock{_remedy(scene)}"
    ]


def _lands_by_law(scene: Scene, block: BlockSpec) -> bool:
    """Whether neither a block nor what carries it deforms."""
    carrier = scene.carrier_of(block)
    firm = not scene.foundation.is_meshed if carrier is None else carrier.model == "rigid"
    return block.model == "rigid" and firm


def cautions_of_steps(scene: Scene, cost: Mapping[str, Any]) -> list[str]:
    """Cautions about steps that are longer than the tolerance asks for, by their counts."""
    coarse, steps = cost.get("coarse_steps", 0), cost.get("steps", 0)
    if coarse <= MOST_COARSE * steps:
        return []
    return [
        f"{coarse} of {steps} steps miss time.tolerance, since time.smallest = "
        f"{scene.time.smallest:g} s allows none that are shorter"
    ]


def cautions_of_end(scene: Scene, status: str, reason: str) -> list[str]:
    """Cautions about a run that a block ended, which fell, or one of several, which overturned."""
    if status != "completed" or not reason:
        return []
    if len(scene.blocks) == 1:
        caught = " fell " not in reason
        return [] if caught else [f"{reason}: nothing catches it, and the run ends there"]
    return [
        f"the run ends before {scene.time.end:g} s ({reason}): what it tells of other blocks is up "
        "to then"
    ]


def cautions_of_impacts(scene: Scene, blocks: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Cautions about impacts from which a block came faster, by the entries of a summary.

    On a foundation that deforms, but does not move as a whole.
    """
    if not scene.foundation.is_meshed or scene.carrier_moves:
        return []
    found = []
    for block in scene.blocks:
        impacts = blocks[block.name]["impacts"] if block.on == "foundation" else []
        faster = [i for i in impacts if i.get("ratio", 0.0) > FASTER]
        if faster:
            first = faster[0]
            found.append(
                f"{block.name} comes from its impact at {first['time_s']:.4g} s "
                f"{first['ratio']:.3g} times as fast as it met it: the foundation vibrates, "
                "and step, mesh and its damping decide what follows"
            )
    return found


def cautions_of_scene(scene: Scene, ground: GroundMotion) -> list[str]:
    """Cautions that no run is needed for."""
    found = [*cautions_of_input(scene, ground), *_undamped_foundation(scene)]
    if not _elastic(scene):
        return found
    if _overruled(scene):
        found.append("[damping] applies to no body: each block has its own damping")
    crossing = min(map(_crossing_time, _elastic(scene)))
    resolving = min(_resolving_step(scene, block) for block in _elastic(scene))
    if not scene.time.adaptive and scene.time.step > resolving:
        found.append(
            f"sound crosses a block in {crossing:.2g} s, so that steps of {scene.time.step:g} s do "
            f"not resolve its impacts and decide what these lose{_remedy(scene)}"
        )
    elif _undamped(scene):
        found.append(
            "nothing damps the blocks, so that what one impact shakes meets the next one and no "
            f"step resolves what that loses{_remedy(scene)}"
        )
    return found


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
    """Whether nothing has the damping of `[damping]`, as in the copy of a scene without one."""
    own = all(block.damping is not None for block in _elastic(scene))
    return scene.damping is not None and own and not scene.foundation.is_meshed


def _undamped_foundation(scene: Scene) -> list[str]:
    """A meshed foundation whose vibration lasts from one impact on it to the next."""
    if not scene.foundation_vibrates or scene.contact.damping:
        return []
    return [
        "nothing damps the foundation, so that what one impact shakes in it meets the next one and "
        "decides what that loses: give foundation.damping.stiffness"
    ]


def _undamped(scene: Scene) -> list[BlockSpec]:
    """The elastic blocks whose strain nothing damps, nor their contact."""
    if scene.contact.damping > 0:
        return []
    damping = [(block, scene.damping_of(block)) for block in _elastic(scene)]
    return [block for block, own in damping if own is None or own.stiffness == 0]


def _remedy(scene: Scene) -> str:
    """What to change."""
    changes = []
    if not scene.time.adaptive:
        changes.append("leave out time.step, so that steps are adaptive")
    elif (scene.time.tolerance or 0.0) > TOLERANCE:
        changes.append(f"leave out time.tolerance, which is {TOLERANCE:g} then")
    if undamped := _undamped(scene):
        most = max(scene.default_damping(block).stiffness for block in undamped)
        changes.append(f"give damping.stiffness, by default {most:.3g} s")
    return f": {', and '.join(changes)}" if changes else ""
