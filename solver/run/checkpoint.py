"""Checkpoints: how a run stands, in one file from which another command goes on.

`checkpoint.npz` holds a header in JSON (versions, scene, ranks, rows of the history, sums) and for
each rank the arrays and counters of the engine, pickled. Only numbers, arrays and the types that
runs save are read back from it.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import pickle
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from solver import VERSION
from solver.errors import SceneError, of_file
from solver.excitation.motion import GroundMotion
from solver.parallel import Comm, Single, any_rank
from solver.scene import Scene
from solver.scene.output import CheckpointSpec
from solver.scene.reader import differing

FORMAT = 23
"""Version of the layout of the file."""

NAME = "checkpoint.npz"

TYPES = {
    "numpy": ("dtype", "ndarray"),
    "numpy._core.multiarray": ("_reconstruct", "scalar"),
    "numpy._core.numeric": ("_frombuffer",),
    "solver.bodies.kinematics": ("RigidMotion",),
    "solver.contact.body_points": ("PointState",),
    "solver.contact.nitsche_points": ("NitscheState",),
    "solver.contact.pairs": ("ActiveFaces",),
    "solver.contact.memory": ("Memory",),
    "solver.contact.kinematics": (
        "ClosestPoints",
        "ContactKinematics",
        "EdgeInterpolation",
        "Projection",
    ),
    "solver.history.events": ("Event", "Meeting"),
    "solver.scheme.generalized_alpha": ("TangentWeights",),
    "solver.scheme.step_control": ("Ladder",),
    "solver.stepping.body_links": ("LinkMemory",),
    "solver.stepping.delassus": ("Delassus",),
    "solver.stepping.local_error": ("Past",),
    "solver.stepping.response": ("CandidateSet", "DenseConfiguration", "ElasticCoupling"),
    "solver.stepping.state": ("State", "RotationPrediction"),
}
"""The types that runs save, by the modules that have them: a checkpoint may name no others."""


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """State that a run goes on from."""

    time: float
    """s."""
    rows: int
    """Rows of the history up to then."""
    part: int
    """Number of the part of the run that goes on."""
    saved: Any
    """Data that this rank saved."""


class Schedule:
    """Schedule of checkpoints."""

    def __init__(self, spec: CheckpointSpec | None, comm: Comm):
        """Count the minutes from now."""
        self._spec, self._comm, self._written = spec, comm, time.monotonic()

    @property
    def wanted(self) -> bool:
        """True if there are any."""
        return self._spec is not None

    def next_step(self, step: int) -> float:
        """The first step after this one after which one is due; infinite where time decides."""
        if self._spec is None or self._spec.steps is None:
            return float("inf")
        return (step // self._spec.steps + 1) * self._spec.steps

    def is_due(self, step: int) -> bool:
        """True if one is due after a step; collective."""
        if self._spec is None:
            return False
        if self._spec.steps is not None:
            return step % self._spec.steps == 0
        assert self._spec.minutes is not None
        late = time.monotonic() - self._written >= 60 * self._spec.minutes
        late = bool(self._comm.bcast(late, root=0))
        if late:
            self._written = time.monotonic()
        return late


def write_checkpoint(
    file: Path, scene: Scene, ground: GroundMotion, kept: Checkpoint, comm: Comm
) -> None:
    """Write a checkpoint; the file is the old one or the new one, never half; collective."""
    own = pickle.dumps(kept.saved, protocol=5)
    parts = [own] if isinstance(comm, Single) else comm.gather(own, root=0)
    if comm.rank != 0 or parts is None:
        return
    header = {
        "format": FORMAT,
        "rockslip": VERSION,
        **_origin(scene, ground),
        "ranks": len(parts),
        "time": kept.time,
        "rows": kept.rows,
        "part": kept.part,
        "sums": [hashlib.sha256(part).hexdigest() for part in parts],
    }
    arrays: dict[str, Any] = {
        "header": np.array(json.dumps(header)),
        **{f"rank{k}": np.frombuffer(part, np.uint8) for k, part in enumerate(parts)},
    }
    draft = file.with_name(file.name + ".part")
    try:
        with draft.open("wb") as stream:
            np.savez(stream, **arrays)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(draft, file)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise of_file(error, file) from error


def read_checkpoint(folder: Path, scene: Scene, ground: GroundMotion, comm: Comm) -> Checkpoint:
    """The checkpoint in the folder of a run, for this rank, of as many ranks as now.

    Raises:
        SceneError: There is none, it is damaged, or it belongs to something else.
    """
    file = folder / NAME
    where = "--resume"
    try:
        with np.load(file, allow_pickle=False) as table:
            header = json.loads(str(table["header"]))
            parts = [table[f"rank{k}"].tobytes() for k in range(int(header["ranks"]))]
        sums = [hashlib.sha256(part).hexdigest() for part in parts]
        damaged = sums != header["sums"]
    except FileNotFoundError:
        got = f"{folder}, which holds no {NAME}"
        allowed = "the folder of a run that has written one (output.checkpoint)"
        raise SceneError(where, got, allowed) from None
    except Exception:  # whatever zip, zlib, numpy and JSON make of damaged bytes
        damaged, header, parts = True, {}, []
    if damaged:
        raise SceneError(where, f"{file}, which is damaged", "a checkpoint as it was written")
    expected = {"format": FORMAT, "rockslip": VERSION, **_origin(scene, ground)}
    words = {"format": "in another format", "rockslip": "of another version of rockslip"}
    words |= {"motion": "of other samples of the motion", "scene": "of another scene"}
    reached = float(header.get("time", 0.0))
    for key, value in expected.items():
        if header.get(key) != value:
            keys = sorted(differing(header.get(key), value)) if key == "scene" else []
            other = f": {keys[0]}" if keys else ""
            raise SceneError(where, f"{file}, {words[key]}{other}", "that of this run")
    if scene.time.end < reached * (1 - 1e-12):
        allowed = f"time.end >= {reached:g}, reached by the checkpoint"
        raise SceneError("time.end", f"{scene.time.end:g}", allowed)
    if len(parts) != comm.size:
        raise SceneError(where, f"{file}, of {len(parts)} ranks", f"as many, not {comm.size}")
    saved = _loaded(parts[comm.rank])
    if any_rank(comm, saved is None):
        got = f"{file}, which holds what no run has saved"
        raise SceneError(where, got, "a checkpoint as it was written")
    counts = int(header["rows"]), int(header["part"]) + 1
    return Checkpoint(reached, *counts, saved)


def _loaded(part: bytes) -> Any:
    """Data that a rank has saved; None where a type is no part of a checkpoint."""
    try:
        return _Reader(io.BytesIO(part)).load()
    except (pickle.UnpicklingError, AttributeError, ImportError):
        return None


class _Reader(pickle.Unpickler):
    """Reads the types that runs save, arrays and plain values, and nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        """The type of a value."""
        if name in TYPES.get(module.replace("numpy.core.", "numpy._core."), ()):  # numpy 1 and 2
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"{module}.{name} is no part of a checkpoint")


def _origin(scene: Scene, ground: GroundMotion) -> dict[str, Any]:
    """Origin of a checkpoint: the scene but for its end, and a digest of its motions.

    Modes that a foundation is reduced to by itself depend on what the ground does up to the end.
    """
    tables = json.loads(json.dumps(scene.to_dict(), default=str))
    if scene.foundation.reduced_modes != "auto":
        del tables["time"]["end"]
    found = hashlib.sha256()
    for part in ground.parts:
        for samples in (getattr(part, "time", None), getattr(part, "value", None)):
            found.update(b"none" if samples is None else np.ascontiguousarray(samples).tobytes())
    return {"scene": tables, "motion": found.hexdigest()}
