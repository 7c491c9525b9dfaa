"""The summary of a run: what is worth knowing without opening its history."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from solver.errors import of_file
from solver.excitation.motion import GroundMotion
from solver.history.events import Event
from solver.history.history import History
from solver.results import energy, rocking
from solver.results.cautions import (
    cautions_of_end,
    cautions_of_impacts,
    cautions_of_run,
    cautions_of_steps,
    loss_shares,
)
from solver.results.effective_mass import friction_mass_ratio
from solver.results.endings import motion_end, overturned_at
from solver.results.events import recorded
from solver.results.flutter import cautions_of_flutter
from solver.results.meetings import Contacts, meetings
from solver.results.motion import CLEAR, BlockMotion, lean_over_alpha, mode
from solver.results.overlaps import overlaps
from solver.scene import BlockSpec, LinkSpec, Scene

STATES = "slack", "taut", "has flowed", "broken"
"""States of a link, by the numbers that the history has for them."""

#: Version of the layout of summary.json.
SCHEMA = 1


def summarise(
    scene: Scene,
    history: History,
    *,
    status: str,
    cost: Mapping[str, Any],
    versions: Mapping[str, str],
    reason: str = "",
    model: str = "",
    cautions: Sequence[str] = (),
    ground: GroundMotion | None = None,
    contacts: Contacts | None = None,
) -> dict[str, Any]:
    """The content of summary.json: what was run, what came of it, how and with which programs.

    The status is "completed", "not converged" or "interrupted", the cost seconds, steps,
    iterations, unknowns and ranks by name. The model is what the history comes from, as pictures
    name it; empty: what the scene says. The cautions are those that were known before. The ground
    tells when its motion is over. The contacts are those that the engine keeps account of.
    """
    events = recorded(scene, history) if len(history) else ()
    blocks = {b.name: _block(b, scene, history, events) for b in scene.blocks if len(history)}
    links = {k.name: _link(k, history, events) for k in scene.links if len(history)}
    platform = _platform(history) if len(history) else {}
    balance = _energy(scene, history) if len(history) else {}
    found = [*cautions_of_steps(scene, cost)]
    if blocks:
        found += cautions_of_run(scene, balance["loss"], balance["scale_J"])
        found += cautions_of_impacts(scene, blocks)
        found += cautions_of_flutter(scene, history)
        found += cautions_of_end(scene, status, reason)
    return {
        "schema": SCHEMA,
        "title": scene.title,
        "model": model or _model(scene),
        "status": status,
        "reason": reason,
        "end_s": float(history["time_s"][-1]) if len(history) else 0.0,
        **({"motion_end_s": motion_end(ground)} if ground is not None and ground.moves else {}),
        **(meetings(scene, history, events, contacts) if len(history) else {}),
        "versions": dict(versions),
        "blocks": blocks,
        "overlaps": overlaps(scene, history) if len(history) and not scene.is_rigid else [],
        **({"links": links} if links else {}),
        **({"platform": platform} if platform else {}),
        "energy": balance,
        "cautions": [*cautions, *found],
        "cost": dict(cost),
    }


def _model(scene: Scene) -> str:
    """Model that makes the history of a scene: finite elements, unless nothing in it is meshed."""
    return "rigid blocks" if scene.is_rigid else "finite elements"


def _block(
    block: BlockSpec, scene: Scene, history: History, events: Sequence[Event]
) -> dict[str, Any]:
    """Entries of one block."""
    motion = BlockMotion(scene, history, block)
    time, angle, shape = motion.time, motion.angle, motion.shape
    slip = np.linalg.norm(motion.slip, axis=1)
    ended = {e.kind: e.time_s for e in events if e.block == block.name}
    over, off = overturned_at(history, block), ended.get("fell")
    standing = time <= min((t for t in (over, off) if t is not None), default=math.inf)
    peaks = rocking.peaks(time, angle, shape.slenderness())
    over_alpha = lean_over_alpha(history, block)
    known = {
        "mode": mode(block.shape, motion, fell=off is not None),
        "overturned_at_s": over,
        "fell_at_s": off,
        "peak_angle_rad": float(np.max(np.abs(motion.lean))),
        "peak_angle_while_standing_rad": float(np.max(np.abs(motion.lean[standing]))),
        "peak_angle_over_alpha": float(np.max(over_alpha)),
        "peak_angle_over_alpha_while_standing": float(np.max(over_alpha[standing])),
        "peak_slip_m": float(np.max(slip)),
        "peak_slip_while_standing_m": float(np.max(slip[standing])),
        "peak_friction_force_N": float(np.max(np.linalg.norm(motion.friction, axis=1))),
        "residual_angle_rad": float(motion.lean[-1]),
        "residual_slip_m": float(motion.slip[-1, 0]),
        "peak_displacement_m": float(np.max(np.linalg.norm(motion.displacement, axis=1))),
        "residual_displacement_m": float(motion.displacement[-1, 0]),
    }
    if scene.dimension == 3:
        known["residual_slip_second_m"] = float(motion.slip[-1, 1])
        known["residual_displacement_second_m"] = float(motion.displacement[-1, 1])
        known["peak_turn_rad"] = float(np.max(np.abs(motion.turn)))
        known["residual_turn_rad"] = float(motion.turn[-1])
    on_ground = scene.carrier_of(block) is None and float(motion.low[0]) <= CLEAR * block.width
    alone = not (scene.links or scene.forces)  # else friction is not all that moves it
    if "platform.acceleration_m_s2" in history and on_ground and alone:
        known["friction_mass_ratio"] = friction_mass_ratio(block, scene, history)
    return known | {
        "impacts": [_impact(e) for e in events if (e.kind, e.block) == ("impact", block.name)],
        "peaks": [{"time_s": at, "angle_rad": abs(value)} for at, value in peaks],
    }


def _impact(event: Event) -> dict[str, Any]:
    """Entries of an impact: its restitution, or why it has none, and what was read instead."""
    known: dict[str, Any] = {"time_s": event.time_s, "restitution": event.restitution}
    if not event.reason:
        return known
    known |= {"restitution": None, "reason": event.reason}
    return known | ({} if math.isnan(event.restitution) else {"ratio": event.restitution})


def _link(link: LinkSpec, history: History, events: Sequence[Event]) -> dict[str, Any]:
    """Entries of a link."""
    force, name = history[f"{link.name}.force_N"], link.name
    own = {event.kind: event for event in events if event.where == name}
    broke, flowed = own.get("break"), own.get("yield")
    peak = float(np.max(np.abs(force)))
    if link.is_axial and broke is not None:
        peak = max(peak, broke.force_N)  # no mean of a step is as large
    known: dict[str, Any] = {"kind": link.kind, "peak_force_N": peak}
    if not link.is_axial:
        ways = [f"{name}.shear_force{way}_N" for way in ("", "_second")]
        shear = [history[column] for column in ways if column in history]
        known["peak_shear_force_N"] = float(np.max(np.linalg.norm(shear, axis=0)))
    extension = history[f"{name}.extension_m"]
    if broke is not None:  # not how far its ends are apart later
        begins = history["time_s"] - history["step_s"]
        extension = extension[begins <= broke.time_s * (1 + 1e-12)]
    state = STATES[int(history[f"{name}.state"][-1])]
    return known | {
        "peak_extension_m": float(extension[np.argmax(np.abs(extension))]),
        "state": state,
        "flowed_at_s": None if flowed is None else flowed.time_s,
        "broke_at_s": None if broke is None else broke.time_s,
    }


def _platform(history: History) -> dict[str, float]:
    """Entries of the platform, for each direction in which it moves."""
    known = {}
    for direction in ("", "_second"):
        if f"platform.drift{direction}_m" in history:
            drift = history[f"platform.drift{direction}_m"]
            known[f"peak_drift{direction}_m"] = float(np.max(np.abs(drift)))
            known[f"residual_drift{direction}_m"] = float(drift[-1])
    for column in history.columns:
        owner, _, name = column.partition(".")
        if owner == "foundation" and not name.endswith("_m_s"):
            known[f"peak_{name.replace('.', '_')}"] = float(np.max(np.abs(history[column])))
    return known


def _energy(scene: Scene, history: History) -> dict[str, Any]:
    """Entries on the energy balance and on where energy went."""
    total, work = history["energy.total_J"], history["energy.input_J"]
    raised = float(energy.gravity_above_upright(scene, history)[0])
    scale = energy.scale(
        work,
        above_rest=float(history["energy.kinetic_J"][0]) + raised,
        weight_height=sum(b.shape.weight(scene.gravity) * b.height for b in scene.blocks),
    )
    loss = energy.losses(history)
    return {
        "scale_J": scale,
        "largest_gain_fraction": energy.largest_gain_fraction(total, work, scale),
        "ledger_error_fraction": energy.ledger_error_fraction(
            history["energy.ledger_error_J"], scale
        ),
        "loss": loss,
        "loss_share": loss_shares(loss, scale),
    }


def write_json(file: Path, summary: Mapping[str, Any]) -> None:
    """Write a summary; numbers that are not known become null, since JSON has no nan."""
    write_whole(file, json.dumps(_plain(summary), indent=2, allow_nan=False) + "\n")


def write_whole(file: Path, text: str) -> None:
    """Write a text; a reader sees the old file or the new one, never half of it."""
    with draft_of(file) as draft:
        draft.write_text(text, encoding="utf-8")


@contextmanager
def draft_of(file: Path) -> Iterator[Path]:
    """The place of a draft, which becomes the file once it is written, or goes if it is not."""
    draft = file.with_name(file.name + ".part")
    try:
        yield draft
        os.replace(draft, file)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise of_file(error, file) from error


def _plain(value: Any) -> Any:
    """A value in the types of JSON."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
