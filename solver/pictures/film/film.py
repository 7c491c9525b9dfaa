"""Films of runs: `rockslip animate`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from solver.errors import SceneError
from solver.pictures.film.encode import Pixels, encoder_for
from solver.pictures.film.screen import screen
from solver.pictures.film.stage import Stage
from solver.pictures.film.strip import RESOLUTION, draw_heading, draw_strip
from solver.pictures.film.take import Take, take
from solver.results.moving import moving_span
from solver.results.runs import Run
from solver.types import Array

SHORTEST = 6.0
"""A film that would be shorter is slowed down to last so long, s."""

MOST_FRAMES = 3000
"""A film has no more frames than this."""

BETWEEN = 160
"""Grey of the line between two stages."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FilmOptions:
    """How to film."""

    fixed: bool = False
    """Whether the ground is seen to move, from a place at rest; else it stands still."""
    slow: float | None = None
    """Seconds of the film for each second of the run; None: 1, or what makes it last 6 s."""
    begin: float | None = None
    """First time, s; None: when something begins to move."""
    end: float | None = None
    """Last time, s; None: when all is at rest."""
    width: int = 960
    """Width of the picture, pixels."""


def film(runs: Sequence[Run], file: Path, options: FilmOptions) -> None:
    """Film runs side by side into a file, whose name ends with .mp4 or .gif."""
    encoder = encoder_for(file)
    dimensions = {run.scene.dimension for run in runs}
    if len(dimensions) > 1:
        raise SceneError(
            str(runs[-1].folder), "a run in another dimension", "runs of one dimension"
        )
    span = _span(runs, options)
    times = frame_times(span, options.slow, encoder.frames_per_second)
    takes = [take(run, times, fixed=options.fixed) for run in runs]
    with screen():
        draft = file.with_name(f"{file.stem}.part{file.suffix}")
        try:
            encoder.write(_frames(takes, span, options.width), draft)
            draft.replace(file)
        finally:
            draft.unlink(missing_ok=True)


def _span(runs: Sequence[Run], options: FilmOptions) -> tuple[float, float]:
    """First and last time that is shown, s."""
    spans = [moving_span(run.scene, run.history) for run in runs]
    begin = min(span[0] for span in spans) if options.begin is None else options.begin
    end = max(span[1] for span in spans) if options.end is None else options.end
    last = max(float(run.history["time_s"][-1]) for run in runs)
    if not 0 <= begin < end:
        raise SceneError("--from, --until", f"{begin:g} and {end:g}", "0 <= from < until, s")
    if begin >= last:
        raise SceneError("--from", f"{begin:g}", f"less than the end of the run, {last:g} s")
    return begin, min(end, last)


def frame_times(span: tuple[float, float], slow: float | None, rate: int) -> Array:
    """Times of the frames, s, at so many frames a second."""
    lasts = span[1] - span[0]
    factor = max(1.0, SHORTEST / lasts) if slow is None else slow
    count = max(2, round(lasts * factor * rate) + 1)
    if count > MOST_FRAMES:
        raise SceneError(
            "--slow", f"{factor:g}, which makes {count} frames", f"at most {MOST_FRAMES} frames"
        )
    return np.asarray(np.linspace(*span, count), dtype=np.float64)


def _frames(takes: Sequence[Take], span: tuple[float, float], width: int) -> Iterator[Pixels]:
    """The frames, one by one."""
    limit = max(each.bodies.stress_limit for each in takes)
    low, high = _window(takes)
    size = _stage_size(low, high, width // len(takes))
    heading = draw_heading([each.run for each in takes], limit, width)
    strip = draw_strip([each.run for each in takes], span, width)
    stages = [Stage(each, size, low, high, limit) for each in takes]
    try:
        for frame, time in enumerate(takes[0].times):
            pictures = [stage.draw(frame) for stage in stages]
            for picture in pictures[1:]:
                picture[:, :1] = BETWEEN
            middle = _wide(np.concatenate(pictures, axis=1), width)
            top = _with_time(heading, time)
            yield np.concatenate([_wide(top, width), middle, _wide(strip.at(time), width)])
    finally:
        for stage in stages:
            stage.close()


def _window(takes: Sequence[Take]) -> tuple[Array, Array]:
    """Least and greatest place that all stages show, m, with room for the floor."""
    low = np.min([each.low for each in takes], axis=0)
    high = np.max([each.high for each in takes], axis=0)
    margin = 0.08 * float(np.max(high - low))
    low[-1] = min(low[-1], min(each.floor for each in takes))
    return low - margin, high + margin


def _stage_size(low: Array, high: Array, width: int) -> tuple[int, int]:
    """Width and height of a stage, pixels: as what it shows, within bounds."""
    extent = high - low
    ratio = float(extent[-1] / (extent[0] if len(extent) == 2 else np.hypot(*extent[:2])))
    return width, round(width * min(max(ratio, 0.4), 0.62 if width > 600 else 0.8))


def _with_time(heading: Pixels, time: float) -> Pixels:
    """The heading with the time at its right end."""
    from matplotlib import get_data_path
    from PIL import Image, ImageDraw, ImageFont

    picture = Image.fromarray(heading)
    font: Any = ImageFont.truetype(f"{get_data_path()}/fonts/ttf/DejaVuSans.ttf", 15)
    place = (picture.width - 12, round(0.06 * RESOLUTION))
    ImageDraw.Draw(picture).text(place, f"t = {time:.2f} s", fill="black", font=font, anchor="ra")
    return np.asarray(picture)


def _wide(pixels: Pixels, width: int) -> Pixels:
    """Pixels cut or filled up with white to a width."""
    missing = max(0, width - pixels.shape[1])
    return np.pad(pixels, ((0, 0), (0, missing), (0, 0)), constant_values=255)[:, :width]
