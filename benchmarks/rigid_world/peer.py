"""A scene of rigid blocks in MuJoCo: `python peer.py SCENE.json`, by a Python that has mujoco.

The file has the dimension, gravity (m/s2), friction, dt (s), the number of steps, amplitude (m/s2)
and frequency (1/s) of a sine of the ground, and for each block size (m), mass (kg), place (m), its
first two axes, and its tilt (rad, towards +x). Prints ms a step of processor time, the deepest
overlap (m) and the largest way of a centre (m), as JSON. Nothing of rockslip is imported.

In the plane bodies have two slides and a hinge. Contacts are as stiff as MuJoCo allows at the step:
time constant 2 dt, elliptic cones, impratio 100.
"""

from __future__ import annotations

import json
import math
import sys
import time
from pathlib import Path
from typing import Any

import mujoco  # type: ignore[import-not-found]
import numpy as np

CONTACT = 'solimp="0.99 0.999 0.00001" condim="3"'
OPTION = 'integrator="implicitfast" cone="elliptic" impratio="100" iterations="200"'
PLANE = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>'


def model(scene: dict[str, Any]) -> str:
    """The scene in MuJoCo's language."""
    law = f'{CONTACT} friction="{scene["friction"]}" solref="{2 * scene["dt"]} 1"'
    joints = "<freejoint/>" if scene["dimension"] == 3 else f'{PLANE}<joint axis="0 1 0"/>'
    bodies = []
    for block in scene["blocks"]:
        size = " ".join(str(edge / 2) for edge in block["size"])
        place = " ".join(map(str, block["place"]))
        bodies.append(
            f'<body pos="{place}" xyaxes="{" ".join(map(str, block["axes"]))}">{joints}'
            f'<geom type="box" size="{size}" mass="{block["mass"]}" {law}/></body>'
        )
    return (
        f'<mujoco><option timestep="{scene["dt"]}" {OPTION} tolerance="1e-12" '
        f'gravity="0 0 {-scene["gravity"]}"/><size memory="800M"/><worldbody>'
        f'<geom type="plane" size="9999 9999 1" {law}/>{"".join(bodies)}</worldbody></mujoco>'
    )


def main() -> None:
    """Run the scene and print."""
    scene = json.loads(Path(sys.argv[1]).read_text("utf-8"))
    made = mujoco.MjModel.from_xml_string(model(scene))
    data = mujoco.MjData(made)
    mujoco.mj_forward(made, data)
    places, deepest, dt = data.xpos.copy(), 0.0, scene["dt"]
    angles: list[list[float]] = []
    began = time.process_time()
    for step in range(scene["steps"]):
        if scene["amplitude"]:
            phase = 2 * math.pi * scene["frequency"] * (data.time + dt / 2)
            made.opt.gravity[0] = -scene["amplitude"] * math.sin(phase)
        mujoco.mj_step(made, data)
        if step % 10 == 0 and data.ncon:
            deepest = min(deepest, float(data.contact.dist[: data.ncon].min()))
        if scene["past"]:
            angles.append(data.qpos[2::3].tolist())
    taken = time.process_time() - began
    found: dict[str, Any] = {
        "ms_a_step": taken / scene["steps"] * 1e3,
        "penetration_m": -deepest,
        "moved_m": float(np.abs(data.xpos - places).max()),
        "program": f"MuJoCo {mujoco.__version__}",
    }
    if scene["past"]:  # hinges start at 0: the first one is tilted already
        leans = np.array(angles) + [block["tilt"] for block in scene["blocks"]]
        found["past_s"] = [float(np.argmax(lean > scene["past"]) + 1) * dt for lean in leans.T]
    print(json.dumps(found))


if __name__ == "__main__":
    main()
