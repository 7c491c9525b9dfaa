"""A summary in a few lines for people."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from solver.results.endings import cut_short
from solver.results.events import ENDS
from solver.results.meetings import meeting_lines

UNKNOWN = "unknown"
"""Text in the place of a number that is not known."""

ROUND_OFF = 1e-6
"""Angles (degrees) and ways (mm) below this are round-off."""

LEAST_SHARE = 5e-4
"""Part of the whole loss below which a cause is not listed: it would be shown as 0.0 %."""

#: As many impacts are listed at most.
LISTED = 8


def report(summary: Mapping[str, Any]) -> str:
    """The result of a run, as lines of text, with what to be careful of."""
    cautions = [f"caution: {text}" for text in summary.get("cautions", [])]
    return "\n".join([*result_lines(summary), *cautions, *told_lines(summary)]) + "\n"


def result_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """The result of a run, a line each."""
    if early := cut_short(summary):
        yield f"the run {early}"
    reason = f": {summary['reason']}" if summary["reason"] else ""
    yield f"{summary['status']} at t = {summary['end_s']:.6g} s{reason}"
    for name, block in summary["blocks"].items():
        yield from _block_lines(name, block)
    for name, link in summary.get("links", {}).items():
        yield _link(name, link)
    if "platform" in summary:
        yield _platform(summary["platform"])
    if energy := summary["energy"]:
        gain, error = (
            _number(energy[f"{name}_fraction"], ".1e") for name in ("largest_gain", "ledger_error")
        )
        scale = _number(energy["scale_J"])
        yield f"energy: largest gain {gain}, ledger error {error} of {scale} J"
        yield _losses(energy["loss"], energy["loss_share"])
    if "horizon" in summary:
        yield _horizon(summary["horizon"])
    if "wall_s" in summary["cost"]:
        yield _cost(summary["cost"])


PERTURBED = {"motion": "motion", "start": "tilt and velocity at the start"}
"""Perturbed quantities of a twin, in words."""


def _horizon(found: Mapping[str, Any]) -> str:
    """Up to when a run and its twin are the same."""
    if found["status"] != "completed":
        return f"horizon: not known, the twin is {found['status']}"
    more = f"{found['perturbation']:g} more {PERTURBED[found['perturbed']]}"
    if found.get("tolerance") is not None:
        more += f" at tolerance {found['tolerance']:g}"
    if found["time_s"] is None:
        return f"horizon: {more} changes nothing up to the end"
    beyond = f"{more} makes a difference of {found['apart']:g} alpha there"
    return f"horizon: the history means something up to t = {found['time_s']:.4g} s; {beyond}"


def residual_slip(block: Mapping[str, Any]) -> float:
    """Residual slip of a block along what carries it, m: in 3-D without a sign."""
    if "residual_slip_second_m" not in block:
        return float(block["residual_slip_m"])
    return math.hypot(block["residual_slip_m"], block["residual_slip_second_m"])


def _block_lines(name: str, block: Mapping[str, Any]) -> Iterator[str]:
    """Lines on one block."""
    angle = _plain(math.degrees(block["peak_angle_rad"]))
    peak, residual = _plain(1e3 * block["peak_slip_m"]), _plain(1e3 * residual_slip(block))
    yield (
        f"{name}: {block['mode']}, peak angle {angle:.4g} degrees, "
        f"peak slip {peak:.3g} mm, residual slip {residual:.3g} mm{_flown(block)}{_turned(block)}"
    )
    impacts = block["impacts"]
    if impacts:
        more = " ..." if len(impacts) > LISTED else ""
        times = " ".join(f"{impact['time_s']:.4f}" for impact in impacts[:LISTED])
        known = [impact["restitution"] for impact in impacts]
        ratios = " ".join(_number(ratio, ".3f") for ratio in known[:LISTED]) + more
        reasons = Counter(i["reason"] for i in impacts if i.get("reason", ENDS) != ENDS)
        none = "; ".join(f"{reason} ({count})" for reason, count in reasons.items())
        if all(_number(ratio) == UNKNOWN for ratio in known):
            ratios = "" if none else UNKNOWN
        impact_word = "impact" if len(impacts) == 1 else "impacts"
        yield f"  {len(impacts)} {impact_word} at {times}{more} s"
        told = [ratios] * bool(ratios) + [f"none: {none}"] * bool(none)
        yield f"  restitution   {'; '.join(told)}"


def _link(name: str, link: Mapping[str, Any]) -> str:
    """The line on a link."""
    words = [f"peak force {link['peak_force_N']:.4g} N"]
    if "peak_shear_force_N" in link:
        words.append(f"peak shear force {link['peak_shear_force_N']:.4g} N")
    words.append(f"peak extension {_plain(1e3 * link['peak_extension_m']):.4g} mm")
    for key, text in (("flowed_at_s", "flows"), ("broke_at_s", "breaks")):
        if link[key] is not None:
            words.append(f"{text} at t = {link[key]:.6g} s")
    return f"{name}: {', '.join(words)}"


def _flown(block: Mapping[str, Any]) -> str:
    """Displacement of a block, where that is more than its slip."""
    moved = _plain(1e3 * block.get("peak_displacement_m", 0.0))
    differs = moved and block["peak_displacement_m"] != block["peak_slip_m"]
    return f", displacement {moved:.3g} mm with what it flew" if differs else ""


def _turned(block: Mapping[str, Any]) -> str:
    """Rotation of a block about the vertical, where that is one of its modes."""
    if "turn" not in block["mode"].split("-"):
        return ""
    return f", turned by {math.degrees(block['peak_turn_rad']):.4g} degrees about the vertical"


CAUSES = {
    "damping": "damping",
    "contact_damping": "contact dashpots",
    "friction": "friction",
    "contact": "contact",
    "numerical": "time integration",
}
"""Names of the causes of losses, in the order in which they are shown."""


def _losses(loss: Mapping[str, float | None], shares: Mapping[str, float]) -> str:
    """Energy lost, by its causes, J and parts of the whole; None of a file is no number."""
    known = [part for part in loss.values() if part is not None and not math.isnan(part)]
    if len(known) < len(loss):
        return "lost: not known"  # of a reference
    if not shares:
        return "lost: nothing"
    parts = [
        f"{100 * shares[key]:.1f} % {words}"
        for key, words in CAUSES.items()
        if abs(shares.get(key, 0.0)) >= LEAST_SHARE
    ]
    return f"lost {_number(sum(known))} J: {', '.join(parts)}"


def told_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """How bodies met, the chain of collapse, and blocks that came to overlap, a line each."""
    yield from meeting_lines(summary)
    for found in summary.get("overlaps", []):
        yield (
            f"{' and '.join(found['blocks'])} overlap from t = {found['time_s']:.6g} s on, by up "
            f"to {found['depth_m']:.3g} m: contact between them was lost, and what follows is not "
            "to be trusted"
        )


FORCES = {
    "peak_base_shear_N": ("peak base shear", "kN"),
    "peak_overturning_moment_Nm": ("peak overturning moment", "kN m"),
}
"""Forces of a platform or structure on the ground in words, by their keys."""


def _platform(platform: Mapping[str, float]) -> str:
    """The line on the platform."""
    words = []
    for direction, along in (("", ""), ("_second", " along y")):
        if f"peak_drift{direction}_m" in platform:
            words += [
                f"peak drift{along} {1e3 * platform[f'peak_drift{direction}_m']:.4g} mm",
                f"residual drift{along} {1e3 * platform[f'residual_drift{direction}_m']:.3g} mm",
            ]
    words += [
        f"{text} {1e-3 * platform[key]:.4g} {unit}"
        for key, (text, unit) in FORCES.items()
        if key in platform
    ]
    return f"platform: {', '.join(words)}"


def _cost(cost: Mapping[str, Any]) -> str:
    """Lines on the cost of a run."""
    words = [f"{cost['wall_s']:.2f} s in the time loop"]
    for key, text in (
        ("setup_s", "{:.2f} s set-up"),
        ("output_s", "{:.2f} s output"),
        ("steps", "{} steps"),
        ("rejected_steps", "{} rejected"),
        ("newton_iterations", "{} iterations"),
        ("factorizations", "{} factorizations"),
        ("unknowns", "{} unknowns"),
        ("ranks", "{} ranks"),
    ):
        if cost.get(key) is not None:
            word = text.format(cost[key])
            words.append(word[:-1] if cost[key] == 1 and word.endswith("s") else word)
    return "cost: " + ", ".join(words)


def _number(value: float | None, form: str = ".4g") -> str:
    """A number, or that it is not known."""
    return UNKNOWN if value is None or math.isnan(value) else format(value, form)


def _plain(value: float) -> float:
    """An angle in degrees or a way in mm, 0 where it is round-off."""
    return 0.0 if abs(value) < ROUND_OFF else value
