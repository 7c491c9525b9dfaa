"""Families of short scenes that drive one or two parameters to extremes."""

from __future__ import annotations

import math

from benchmarks.stability.matrix import StabilityCase, StabilityFamily
from benchmarks.stability.scenes import (
    ASIDE,
    BODIES,
    CARRIERS,
    DEFAULT_STEPS,
    FALLING,
    FRAME,
    IN_SPACE,
    LANDING,
    MESHED_NEIGHBOURS,
    MESHES,
    MODELS,
    MODULI,
    NEIGHBOURS,
    ON_ITS_CORNER,
    PAIRS,
    PLATE,
    PLATFORM,
    RIGID,
    ROCK,
    ROLLERS,
    SHAKE,
    SINE,
    SPACE,
    SQUAT,
    STACK,
    STACKED,
    gaps,
    mass_ratios,
    over,
    sizes,
    slenderness,
    steps,
    tower,
)
from solver.study.scenes import changed

ALPHA = math.degrees(math.atan2(0.25, 1.0))
"""Slenderness of the paper's block, degrees."""

NEEDLE = math.degrees(math.atan2(0.01, 1.0))
"""Slenderness angle of the needle, degrees."""

FAMILIES: tuple[StabilityFamily, ...] = (
    StabilityFamily(
        name="stiffness E (Pa)",
        base=ROCK,
        rows=steps(1e-6, 1e-5, 1e-4, 1e-3, 5e-3, 5e-2),
        columns=MODULI,
    ),
    StabilityFamily(
        name="Poisson's ratio",
        base=SHAKE,
        rows=MESHES,
        columns=over("block.poisson", (0.0, 0.3, 0.4, 0.49, 0.499, 0.4999)),
    ),
    StabilityFamily(
        name="Nitsche's gamma",
        base=ROCK,
        rows={f"theta {theta}": {"contact.theta": theta} for theta in (1, 0, -1)},
        columns=over("contact.gamma", (1, 3, 10, 30, 100, 1000, 1e4)),
    ),
    StabilityFamily(
        name="rho_inf",
        base=SHAKE,
        rows={
            "elastic": {},
            "soft": {"block.young": 1e7},
            "rigid": RIGID,
            "gauss": {"contact.points": "gauss"},
        },
        columns=over("time.rho_inf", (0.0, 0.25, 0.5, 0.8, 1.0)),
    ),
    StabilityFamily(
        name="friction mu",
        base=SHAKE,
        rows={**BODIES, "elastic, dt 5e-3": {"time.step": 5e-3}},
        columns=over("contact.friction", (0.0, 0.1, 0.5, 1.0, 10.0, 100.0, 1000.0)),
    ),
    StabilityFamily(
        name="density (kg/m3)",
        base=ROCK,
        rows=over("block.young", (1e6, 1e9, 1e12)),
        columns=over("block.density", (1.0, 30.0, 1000.0, 2e4)),
    ),
    StabilityFamily(
        name="slenderness",
        base=ROCK,
        rows=BODIES,
        columns=slenderness(0.1, 0.3, 1.0, 3.0, 10.0, 30.0),
    ),
    StabilityFamily(
        name="size (height)",
        base=ROCK,
        rows={**BODIES, "soft": {"block.young": 1e8}},
        columns=sizes(0.01, 0.1, 1.0, 10.0, 100.0),
    ),
    StabilityFamily(
        name="mass ratio of a stack",
        base=STACK,
        rows=PAIRS,
        columns=mass_ratios(1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 1e2, 1e3, 1e4),
    ),
    StabilityFamily(
        name="tilt over alpha",
        base=ROCK,
        rows=BODIES,
        columns={
            f"{part:g}": {"block.tilt_deg": part * ALPHA}
            for part in (-0.999, 0.01, 0.5, 0.9, 0.99, 0.999, 1.001, 1.01)
        },
    ),
    StabilityFamily(
        name="base motion (g)",
        base=SHAKE,
        rows={
            "elastic, sine": {},
            "rigid, sine": RIGID,
            "elastic, ricker": {
                **{"motion.kind": "ricker", "motion.period": None, "motion.frequency": 4.0},
            },
            "stack, rectangular": {
                "block": STACK["block"],
                **{"motion.kind": "rectangular", "motion.period": None, "motion.duration": 0.2},
            },
        },
        columns=over("motion.amplitude_g", (0.1, 1.0, 3.0, 10.0)),
    ),
    StabilityFamily(
        name="vertical motion (g)",
        base={**SHAKE, "motion": {**SINE, "vertical": {**SINE, "period": 0.25}}},
        rows={**BODIES, **STACKED},
        columns=over("motion.vertical.amplitude_g", (0.9, 1.1, 2.0, 5.0)),
    ),
    StabilityFamily(
        name="gravity",
        base=ROCK,
        rows=MODELS,
        columns={
            "0, moving": {"gravity": 0.0, "block.tilt_deg": 0.0, "block.angular_velocity": 1.0},
            "0, shaken": {"gravity": 0.0, "block.tilt_deg": 0.0, "motion": SINE},
            "0, at rest": {"gravity": 0.0, "block.tilt_deg": 0.0},
            "0.01": {"gravity": 0.01},
            "1000": {"gravity": 1000.0, "time.step": 1e-4, "time.end": 0.06},
            "incline 10": {"gravity_tilt_deg": 10.0, "block.tilt_deg": 0.0},
            "incline 40": {"gravity_tilt_deg": 40.0, "block.tilt_deg": 0.0},
        },
    ),
    StabilityFamily(
        name="damping beta_R (s)",
        base=ROCK,
        rows=over("block.young", (1e7, 5e10)),
        columns=over("damping.stiffness", (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)),
    ),
    StabilityFamily(
        name="cohesion (Pa)",
        base=SHAKE,
        rows={
            "elastic": {},
            "elastic, lost": {"contact.friction.cohesion_lost": True},
            "rigid": RIGID,
            **STACKED,
        },
        columns={
            f"{c:g}": {"contact.friction": {"static": 0.3, "cohesion": c}}
            for c in (1e2, 1e4, 1e6, 1e8)
        },
    ),
    StabilityFamily(
        name="friction that falls",
        base=SHAKE,
        rows={**MODELS, **STACKED},
        columns={
            f"DC {decay:g}, to {dynamic:g}": {
                "contact.friction": {"static": 0.5, "dynamic": dynamic, "decay": decay}
            }
            for decay in (0.0, 1.0, 1e3, 1e6)
            for dynamic in (0.0, 0.3)
        },
    ),
    StabilityFamily(
        name="platform period (s)",
        base={**SHAKE, "foundation": PLATFORM},
        rows={
            **BODIES,
            "mass ratio 100": {"foundation.mass_ratio": 100.0},
            "mass ratio 0.01": {"foundation.mass_ratio": 0.01},
            "plate on rollers": {
                **{f"foundation.{key}": value for key, value in ROLLERS.items() if key != "period"},
                "foundation.mass_ratio": None,
            },
        },
        columns=over("foundation.period", (0.01, 0.03, 0.1, 0.5, 2.0, 10.0)),
    ),
    StabilityFamily(
        name="cells",
        base=ROCK,
        rows=MESHES,
        columns={
            **over("block.cells", ([1, 1], [1, 32], [24, 2], [8, 16])),
            **{f"graded {r:g}": {"block.refinement": r} for r in (10.0, 1000.0)},
        },
    ),
    StabilityFamily(
        name="what carries",
        base=SHAKE,
        rows={**MODELS, **STACKED},
        columns={
            "plate": {"foundation": PLATE},
            "soft plate": {"foundation": {**PLATE, "young": 1e7}},
            "stiff plate": {"foundation": {**PLATE, "young": 1e13}},
            "plate, degree 2": {"foundation": {**PLATE, "degree": 2}},
            "plate, triangles": {"foundation": {**PLATE, "cell": "triangle"}},
            "rollers": {"foundation": ROLLERS},
            "frame": {"foundation": FRAME},
            "held plate": {"foundation": {**PLATE, "support": "fixed"}},
        },
    ),
    StabilityFamily(
        name="at the edge of a plate",
        base={**SHAKE, "foundation": PLATE},
        rows={
            **MODELS,
            "held plate": {"foundation.support": "fixed"},
            "soft plate": {"foundation.young": 1e8},
        },
        columns={
            f"overhang {part:g} B": {"block.offset": 0.75 - 0.125 + 0.25 * part}
            for part in (0.0, 1e-9, 0.01, 0.25, 0.49, 0.51, 1.0)
        },
    ),
    StabilityFamily(
        name="needle (tilt over alpha)",
        base=changed(ROCK, {"block.width": 0.01, "block.cells": [2, 20], "block.young": 2e11}),
        rows={**BODIES, "elastic, mu 0": {"contact.friction": 0.0}},
        columns={
            f"{part:g}": {"block.tilt_deg": part * NEEDLE}
            for part in (0.0, 0.5, 0.999999, 1.0, 3.0)
        },
    ),
    StabilityFamily(
        name="towers",
        base=tower(3),
        rows={"elastic": {}, "rigid": RIGID, "soft": {"block.young": 1e8}},
        columns={f"{count} blocks": {"block": tower(count)["block"]} for count in (2, 3, 5, 10)},
    ),
    StabilityFamily(
        name="in space",
        base=SPACE,
        rows={
            "shaken": {},
            "on its corner": ON_ITS_CORNER,
            "degree 2, gauss": {
                **{"block.degree": 2, "contact.points": "gauss", "block.cells": [2, 2, 3]},
            },
            "tetrahedra": {"block.cell": "tetrahedron", "block.cells": [2, 2, 4]},
        },
        columns=over("block.young", (1e6, 1e8, 1e10, 1e13)),
    ),
    StabilityFamily(
        name="in space, friction mu",
        base=SPACE,
        rows={
            "elastic": {},
            "on its corner": ON_ITS_CORNER,
            "rigid, on its corner": {**RIGID, **ON_ITS_CORNER},
        },
        columns=over("contact.friction", (0.0, 0.1, 1.0, 10.0, 1000.0)),
    ),
    StabilityFamily(
        name="default steps, E (Pa)",
        base=changed(ROCK, DEFAULT_STEPS),
        rows=over("damping.stiffness", (0.0, 1e-5, 1e-3)),
        columns=MODULI,
    ),
    StabilityFamily(
        name="default steps, friction mu",
        base=changed(SHAKE, DEFAULT_STEPS),
        rows={**MODELS, **STACKED, **CARRIERS},
        columns=over("contact.friction", (0.0, 0.1, 0.5, 10.0)),
    ),
    StabilityFamily(
        name="default steps and damping, E (Pa)",
        base=changed(SHAKE, {**DEFAULT_STEPS, "damping": None}),
        rows={
            "shaken": {},
            "landing flat": {**LANDING, "motion": None},
            **STACKED,
            **CARRIERS,
        },
        columns=over("block.young", (1e7, 1e9, 1e11, 1e13)),
    ),
    StabilityFamily(
        name="bed (Pa/m)",
        base=changed(ROCK, {"contact.damping": 0.1}),
        rows={
            "rocking": {},
            "landing flat": LANDING,
            "landing flat, default steps": {**LANDING, **DEFAULT_STEPS},
            "no damping": {"contact.damping": 0.0},
            "critical": {"contact.damping": 1.0},
            "stack": {"block": STACK["block"], "motion": SINE},
        },
        columns=over("contact.stiffness", (3e7, 1e9, 1e11, 1e14)),
    ),
    StabilityFamily(
        name="restitution of rigid blocks",
        base=changed(ROCK, RIGID),
        rows={
            "rocking": {},
            "rocking, space": IN_SPACE,
            "on its corner": {**IN_SPACE, **ON_ITS_CORNER},
            "landing flat": LANDING,
            "landing flat, space": {**LANDING, **IN_SPACE, "block.velocity": [0.0, 0.0, -1.4]},
            "stack": {"block": STACK["block"], "block.model": "rigid", "motion": SINE},
        },
        columns=over("block.restitution", (0.01, 0.3, 0.9, 0.95, 1.0)),
    ),
    StabilityFamily(
        name="damping of one block, beta_R (s)",
        base=STACK,
        rows={"fixed steps": {}, "default steps": DEFAULT_STEPS},
        columns={
            "1e-05": {"upper.damping": {"stiffness": 1e-5}},
            "0.001, lambda_R 10": {"upper.damping": {"stiffness": 1e-3, "mass": 10.0}},
        },
    ),
    StabilityFamily(
        name="gap between neighbours",
        base=NEIGHBOURS,
        rows={key: ASIDE[key] for key in ("plane", "space", "on a platform")},
        columns=gaps(0.0, 1e-9, 1e-6, 1e-3, 0.1),
    ),
    StabilityFamily(
        name="mass ratio of neighbours",
        base=NEIGHBOURS,
        rows=ASIDE,
        columns={
            f"{ratio:g}": {
                **{"block.density": None, "left.mass": 250.0, "right.mass": 250.0},
                "middle.mass": 250.0 * ratio,
            }
            for ratio in (1e-4, 1e-2, 1.0, 1e2, 1e4)
        },
    ),
    StabilityFamily(
        name="restitution of neighbours",
        base=NEIGHBOURS,
        rows=ASIDE,
        columns=over("block.restitution", (0.05, 0.5, 0.95, 1.0)),
    ),
    StabilityFamily(
        name="friction of neighbours",
        base=NEIGHBOURS,
        rows=ASIDE,
        columns=over("contact.friction", (0.0, 0.1, 1.0, 10.0, 1000.0)),
    ),
    StabilityFamily(
        name="stiffness of elastic neighbours",
        base=MESHED_NEIGHBOURS,
        rows=ASIDE,
        columns=over("block.young", (1e7, 1e8, 1e10, 1e12)),
    ),
    StabilityFamily(
        name="gap between elastic and rigid neighbours",
        base=MESHED_NEIGHBOURS,
        rows={
            "elastic": {},
            "middle rigid": {"middle.model": "rigid"},
            "middle elastic": {"left.model": "rigid", "right.model": "rigid"},
            "on a plate": {"foundation": PLATE},
            "default steps": {"time.step": None},
        },
        columns=gaps(0.0, 1e-9, 1e-6, 1e-3, 0.1),
    ),
    StabilityFamily(
        name="slip beside the reference",
        base=SQUAT,
        rows={
            "default": {},
            "dt 2e-4": {"time.step": 2e-4},
            "rigid": RIGID,
            "rigid, space": {**RIGID, **IN_SPACE},
        },
        columns={
            **{
                f"DC {decay:g}": {"block.friction": {**FALLING, "decay": decay}}
                for decay in (5.0, 20.0, 100.0)
            },
            "constant": {"block.friction": 0.3},
            "firm ground": {"foundation": {"kind": "rigid"}, "motion.amplitude_g": 0.7},
        },
        compared=True,
    ),
)


def matrix() -> list[StabilityCase]:
    """Every scene of the study, family by family."""
    return [case for family in FAMILIES for case in family.cases()]
