"""Files of films: MP4 by ffmpeg, GIF by Pillow."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from solver.errors import EnvironmentTrouble, SceneError
from solver.pictures.renderer import Pixels

COLOURS = 192
"""Colours of a GIF; more make the file larger, fewer make bands of the stress."""

SAMPLED = 6
"""Frames that the colours of a GIF are chosen from."""


class Encoder(NamedTuple):
    """What writes the frames of a film."""

    frames_per_second: int
    """Frames that are shown in a second."""
    write: Callable[[Iterable[Pixels], Path], None]
    """Writes a film of frames, one or more, all of one size."""


def write_mp4(frames: Iterable[Pixels], file: Path) -> None:
    """H.264 in MP4, which every browser plays: pass the frames to ffmpeg as they come."""
    process: subprocess.Popen[bytes] | None = None
    for frame in frames:
        # Its colours are halved in both directions, so that sizes have to be even.
        even = frame[: frame.shape[0] // 2 * 2, : frame.shape[1] // 2 * 2]
        if process is None:
            process = _start_ffmpeg(even.shape[1], even.shape[0], file)
        assert process.stdin is not None
        try:
            process.stdin.write(np.ascontiguousarray(even).tobytes())
        except BrokenPipeError:
            break  # it has ended, and its message says why
    assert process is not None
    _, said = process.communicate()
    if process.returncode:
        why = said.decode(errors="replace").strip().splitlines()[-1:]
        raise EnvironmentTrouble(f"ffmpeg: {' '.join(why) or 'failed'}")


def _start_ffmpeg(width: int, height: int, file: Path) -> subprocess.Popen[bytes]:
    """Start ffmpeg, which takes raw frames from its standard input."""
    words = ["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]
    words += ["-s", f"{width}x{height}", "-r", str(ENCODERS[".mp4"].frames_per_second), "-i", "-"]
    words += ["-pix_fmt", "yuv420p", "-movflags", "+faststart", str(file)]
    return subprocess.Popen(words, stdin=subprocess.PIPE, stderr=subprocess.PIPE)


def write_gif(frames: Iterable[Pixels], file: Path) -> None:
    """GIF, which needs no program and plays anywhere, over and over: of what changes in frames."""
    from PIL import Image

    pictures = [Image.fromarray(frame) for frame in frames]
    chosen = pictures[:: max(1, len(pictures) // SAMPLED)]
    palette = _sample(chosen).quantize(COLOURS, kmeans=2, dither=Image.Dither.NONE)
    indexed = [p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures]
    indexed[0].save(
        file,
        save_all=True,
        append_images=indexed[1:],
        duration=1000 // ENCODERS[".gif"].frames_per_second,
        loop=0,
    )


def _sample(pictures: Sequence[Any]) -> Any:
    """A picture to choose colours from: each as often as the root of how often it is used.

    Arrows and marks are small, and would find no colour beside the floor.
    """
    from PIL import Image

    pixels = np.concatenate([np.asarray(picture).reshape(-1, 3) for picture in pictures])
    codes = pixels.astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], dtype=np.uint32)
    found, counts = np.unique(codes, return_counts=True)
    repeated = np.repeat(found, np.sqrt(counts).astype(int))
    rows = np.stack([repeated >> 16, repeated >> 8 & 255, repeated & 255], axis=1)
    return Image.fromarray(rows.astype(np.uint8)[None])


ENCODERS = {".mp4": Encoder(25, write_mp4), ".gif": Encoder(20, write_gif)}
"""By the endings of files."""


def default_ending() -> str:
    """The best format that can be written here."""
    return ".mp4" if shutil.which("ffmpeg") else ".gif"


def encoder_for(file: Path) -> Encoder:
    """Encoder of a film by the ending of its name; refused where there is none."""
    ending = file.suffix.lower()
    if ending not in ENCODERS:
        raise SceneError("-o", file.name, "a name that ends with .mp4 or .gif")
    if ending == ".mp4" and not shutil.which("ffmpeg"):
        raise EnvironmentTrouble("ffmpeg, which writes .mp4, is not installed; .gif needs nothing")
    return ENCODERS[ending]
