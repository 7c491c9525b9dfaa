"""`rockslip scale`: a scene at another scale, and the motions of its ground beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from solver.errors import SceneError
from solver.excitation.motion import read_ground
from solver.excitation.sampled import SampledMotion
from solver.results.summary import write_whole
from solver.run.folders import open_folder
from solver.scene import Scene, parse_scene
from solver.scene.scaling import Scale, scaled_tables


def rescaled(scene: Scene, scale: Scale, file: Path | None) -> str:
    """The scene at another scale as TOML; motions from samples are written beside its file.

    Args:
        scene: The prototype.
        scale: Of the model.
        file: Where the scene goes, which names those of the motions; None: nowhere.

    Raises:
        SceneError: There are samples and no file beside which they could go, or the model is
            beyond the limits of scenes, and nothing is written then; a file exists.
    """
    import tomli_w

    if file is not None:
        open_folder(file.parent)
    sampled = _sampled(scene)
    if sampled and file is None:
        allowed = "-o FILE, beside which its samples go at the new scale"
        raise SceneError(next(iter(sampled)), "a motion from samples", allowed)
    files = {} if file is None else {path: _beside(file, path) for path in sampled}
    for there in (file, *files.values()):
        if there is not None and there.exists():
            raise SceneError("-o", f"{there}, which exists", "a new file")
    try:
        motions = {path: _table(sampled[path], scale, beside) for path, beside in files.items()}
        tables = scaled_tables(scene, scale, motions)
        times = 1 / scale.lengths if scale.lengths < 1 else scale.lengths
        ratio = f"1:{times:.6g}" if scale.lengths < 1 else f"{times:.6g}:1"
        tables["title"] = f"{scene.title}, {ratio}" if scene.title else ratio
        parse_scene(tables, folder=file.parent if file else ".")  # is refused here if it is none
        text = tomli_w.dumps(tables)
        if file is not None:
            write_whole(file, text)
    except BaseException:
        for beside in files.values():
            beside.unlink(missing_ok=True)
        raise
    return text


def _sampled(scene: Scene) -> dict[str, SampledMotion]:
    """The motions of the ground that are given by samples, by the paths of their tables."""
    if not scene.motions:
        return {}
    parts = zip(scene.directions, read_ground(scene).parts, strict=True)
    return {path: part for path, part in parts if isinstance(part, SampledMotion)}


def _beside(file: Path, path: str) -> Path:
    """File for the samples of a motion, beside that of the scene, by the path of its table."""
    direction = path.rpartition("motion.")[2] if path != "motion" else ""
    return file.with_name(f"{file.stem}_{f'{direction}_' if direction else ''}motion.csv")


def _table(motion: SampledMotion, scale: Scale, beside: Path) -> dict[str, Any]:
    """The table of a motion whose samples have been written at the new scale."""
    lines = ["time_s,acceleration_m_s2"]
    lines += [
        f"{float(time) * scale.times!r},{float(value)!r}"
        for time, value in zip(motion.time, motion.value, strict=True)
    ]
    write_whole(beside, "\n".join(lines) + "\n")
    return {"kind": "table", "file": beside.name, "units": "m/s2"}
