"""Films: when things move, where forces act, and files that play."""

from __future__ import annotations

import stat
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_runs import IN_SPACE, T, in_space, leave_run, stack

from rockslip import parse_scene, read_run, simulate
from solver.cli import main
from solver.errors import EnvironmentTrouble, SceneError
from solver.results.moving import moving_span

pytest.importorskip("matplotlib")
pytest.importorskip("pyvista")
pytest.importorskip("PIL")


def frames(file: Path) -> list[np.ndarray]:
    """All frames of a GIF."""
    from PIL import Image

    film = Image.open(file)
    found = []
    for k in range(film.n_frames):
        film.seek(k)
        found.append(np.asarray(film.convert("RGB")).astype(int))
    return found


def test_what_moves_is_found(tmp_path: Path) -> None:
    """A block that leans between 0.5 and 1.2 s: that, with a twentieth of it on both sides."""
    lean = 0.05 * np.where((T > 0.5) & (T < 1.2), np.sin((T - 0.5) / 0.7 * np.pi) ** 2, 0)
    run = read_run(leave_run(tmp_path / "a", parse_scene(IN_SPACE), {"block.angle_x_rad": lean}))
    begin, end = moving_span(run.scene, run.history)
    assert begin == pytest.approx(0.5 - 0.035, abs=0.03)
    assert end == pytest.approx(1.2 + 0.035, abs=0.03)
    run = read_run(leave_run(tmp_path / "b", parse_scene(IN_SPACE), {}))
    assert moving_span(run.scene, run.history) == (0.0, 2.0)


def test_a_slide_is_over_where_it_ends(tmp_path: Path) -> None:
    """It rests at another place than it began."""
    slip = 0.1 * np.clip((T - 0.8) / 0.4, 0, 1)
    run = read_run(leave_run(tmp_path / "a", parse_scene(IN_SPACE), {"block.slip_m": slip}))
    begin, end = moving_span(run.scene, run.history)
    assert begin == pytest.approx(0.78, abs=0.01)
    assert end == pytest.approx(1.22, abs=0.01)


def test_forces_act_where_blocks_touch(tmp_path: Path) -> None:
    """The upper block on the corner that it leans to; an impact counts by its impulse."""
    from solver.pictures.contact import State, block_frames

    run = read_run(stack(tmp_path / "stack"))
    times = np.linspace(0, 2, 101)
    lower, upper = (block_frames(run, block, times) for block in run.scene.blocks)
    corner = upper.centres[0] + upper.frames[0] @ np.array([0.15, -0.5])
    np.testing.assert_allclose(upper.push.place[0], corner, atol=1e-6)
    # it stands upright on both corners at the zero of its angle
    flat = int(np.argmin(np.abs(upper.frames[:, 0, 1])))
    middle = upper.centres[flat] - [0, 0.5]
    np.testing.assert_allclose(upper.push.place[flat], middle, atol=0.1)
    np.testing.assert_allclose(upper.push.force[:, 1], 1.0, atol=1e-9)
    # 31 weights for one step of 2 ms, and else the weight
    struck = np.sum(lower.push.force[:, 1] - 1) * 0.02
    assert struck == pytest.approx(30 * 0.002, rel=1e-6)
    assert lower.push.states[30] is State.SLIPS
    assert set(upper.push.states) == {State.STICKS}


def test_the_way_of_the_ground(tmp_path: Path) -> None:
    """Twice the integral of a sine."""
    from solver.pictures.film import ground_path

    scene = parse_scene(IN_SPACE + "[motion]\nkind = 'sine'\namplitude_g = 0.1\nperiod = 1\n")
    values = {"base.acceleration_m_s2": 0.981 * np.sin(2 * np.pi * T)}
    run = read_run(leave_run(tmp_path / "a", scene, values))
    turn = 2 * np.pi * T
    expected = 0.981 / (2 * np.pi) ** 2 * (turn - np.sin(turn))
    np.testing.assert_allclose(ground_path(run, T)[:, 0], expected, atol=1e-5)


@pytest.mark.parametrize("make", [stack, in_space])
def test_a_film(make: object, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It has the frames asked for, which differ where the block is, and are not empty."""
    folder = make(tmp_path / "run")  # type: ignore[operator]
    words = ["--from", "0", "--until", "0.5", "--slow", "1", "--width", "480"]
    file = tmp_path / "film.gif"
    assert main(["animate", str(folder), "-o", str(file), *words]) == 0
    assert capsys.readouterr().out == f"{file}\n"
    shown = frames(file)
    assert len(shown) == 11
    assert shown[0].shape[1] == 480
    stage = slice(70, shown[0].shape[0] - 150)
    drawn = np.any(shown[0][stage] < 245, axis=2)
    assert 0.05 < drawn.mean() < 0.9
    assert np.any(np.abs(shown[0][stage] - shown[-1][stage]) > 60, axis=2).mean() > 0.002
    assert list(tmp_path.glob("*.part*")) == []


def test_two_runs_side_by_side(tmp_path: Path) -> None:
    folder = str(stack(tmp_path / "stack"))
    words = ["--until", "0.1", "--slow", "1", "--width", "640", "--frame", "fixed"]
    file = tmp_path / "both.gif"
    assert main(["animate", folder, folder, "-o", str(file), *words]) == 0
    (frame, *_) = frames(file)
    left, right = frame[80:200, 2:318], frame[80:200, 322:638]
    assert np.abs(left - right).mean() < 1


def test_what_cannot_be_filmed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from solver.pictures.encode import encoder_for
    from solver.pictures.film import FilmOptions, film, frame_times

    plane, space = read_run(stack(tmp_path / "a")), read_run(in_space(tmp_path / "b"))
    with pytest.raises(SceneError, match="dimension"):
        film([plane, space], tmp_path / "film.gif", FilmOptions())
    with pytest.raises(SceneError, match="less than the end"):
        film([plane], tmp_path / "film.gif", FilmOptions(begin=3.0, end=4.0))
    with pytest.raises(SceneError, match="frames"):
        frame_times((0.0, 1.0), 1e4, 25)
    with pytest.raises(SceneError, match=r"\.gif"):
        encoder_for(tmp_path / "film.avi")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(EnvironmentTrouble, match="ffmpeg"):
        encoder_for(tmp_path / "film.mp4")
    assert main(["animate", str(tmp_path / "a"), "-o", str(tmp_path / "no" / "film.gif")]) == 2


def test_ffmpeg_gets_the_frames(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Even sizes, all bytes; its error messages are reported."""
    from solver.pictures.encode import encoder_for

    program = tmp_path / "ffmpeg"
    program.write_text('#!/bin/sh\nfor last; do :; done\necho "$@" >"$last.words"\ncat >"$last"\n')
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin")
    file = tmp_path / "film.mp4"
    encoder_for(file).write((np.full((9, 7, 3), k, np.uint8) for k in range(3)), file)
    assert file.read_bytes() == b"".join(bytes([k]) * (8 * 6 * 3) for k in range(3))
    assert "-s 6x8 -r 25" in Path(f"{file}.words").read_text()
    program.write_text("#!/bin/sh\ncat >/dev/null\necho no encoder >&2\nexit 1\n")
    with pytest.raises(EnvironmentTrouble, match="ffmpeg: no encoder"):
        encoder_for(file).write([np.zeros((8, 8, 3), np.uint8)], file)


LINKED = """
[[block]]
model = "rigid"
width = 0.3
height = 1.0
mass = 100.0
[[link]]
name = "wire"
kind = "tether"
between = ["block", "foundation"]
at = [0.15, 1.0]
to = [0.6, 0.0]
stiffness = 1e4
strength = {strength}
[[force]]
on = "block"
at = [0.0, 1.0]
force = [-300.0, 0.0]
ramp = [0.0, 0.5]
[time]
end = 0.6
step = 1e-3
[output]
fields = "none"
"""


def test_links_are_drawn_where_their_ends_are_until_they_break(tmp_path: Path) -> None:
    from solver.pictures.links import links_of

    scene = parse_scene(LINKED.format(strength="100.0"))
    simulate(scene, folder=tmp_path)
    run = read_run(tmp_path)
    times = run.history["time_s"][::10]
    (link,) = links_of(run, times)
    ends, states = link.ends, link.states
    longer = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) - np.hypot(0.45, 1.0)
    whole = states < 3.0
    assert longer[whole] == pytest.approx(run.history["wire.extension_m"][::10][whole], abs=1e-12)
    assert ends[0] == pytest.approx(np.array([[0.15, 1.0], [0.6, 0.0]]))
    assert states[-1] == 3 and 1 in states
    # A fifth of it is left at each end, or as much as there is room for.
    last = len(times) - 1
    for longest, left in ((9.0, 0.2 * np.linalg.norm(ends[-1, 1] - ends[-1, 0])), (0.1, 0.1)):
        lines = link.lines(last, longest)
        assert [line[0] for line in lines] == [pytest.approx(end) for end in ends[-1]]
        assert [np.linalg.norm(line[1] - line[0]) for line in lines] == pytest.approx([left] * 2)
    assert len(link.lines(0, 0.1)) == 1


def test_arrows_have_one_scale_for_all_blocks(tmp_path: Path) -> None:
    """A light low block on a heavy tall one: at rest arrows of 0.3 of the tall one's height."""
    from solver.pictures.film import Shot

    common = "model = 'rigid'\nthickness = 1.0\n"
    scene = parse_scene(
        f"[[block]]\nname = 'low'\n{common}width = 1.0\nheight = 2.0\nmass = 800.0\n"
        f"[[block]]\nname = 'up'\non = 'low'\n{common}width = 0.2\nheight = 0.1\nmass = 200.0\n"
        "[time]\nend = 0.1\nstep = 1e-3\n[output]\nfields = 'none'\n"
    )
    simulate(scene, folder=tmp_path)
    drawn: list[float] = []

    class Measure:
        def draw(self, _: object, arrows: list[tuple[Any, str]], __: object) -> np.ndarray:
            drawn.extend(arrow.bounds[3] - arrow.bounds[2] for arrow, _ in arrows)
            return np.zeros((1, 1, 3), np.uint8)

    Shot(read_run(tmp_path), np.array([0.04, 0.05]), fixed=False).draw(Measure(), 1)
    assert drawn == pytest.approx([0.6, 0.12], rel=1e-3)


def test_the_film_of_a_linked_block_shows_its_link(tmp_path: Path) -> None:
    pictures = []
    for strength in ("1e5", "1e-3"):
        folder = tmp_path / strength
        simulate(parse_scene(LINKED.format(strength=strength)), folder=folder)
        words = ["--from", "0.3", "--until", "0.4", "--slow", "1", "--width", "480"]
        assert main(["animate", str(folder), "-o", str(folder / "film.gif"), *words]) == 0
        pictures.append(frames(folder / "film.gif")[-1])
    held, lost = (np.count_nonzero(picture.max(axis=2) < 60) for picture in pictures)
    assert held > lost + 200


def test_stills_show_links_whole_and_broken(tmp_path: Path) -> None:
    """A wire is a line of the colour of its state, broken ones are drawn at their ends alone."""
    from matplotlib.colors import to_rgb
    from PIL import Image

    from solver.pictures.links import LOOKS

    counts = {}
    for strength in ("1e5", "1e-3"):
        folder = tmp_path / strength
        text = LINKED.format(strength=strength).replace('fields = "none"', "every = 0.3")
        simulate(parse_scene(text), folder=folder)
        assert main(["plot", str(folder)]) == 0
        drawn = np.asarray(Image.open(folder / "deformed.png").convert("RGB")).astype(int)
        red = 255 * np.array(to_rgb(LOOKS[3][1]))
        counts[strength] = np.count_nonzero(np.abs(drawn - red).max(axis=2) < 20)
        forces = np.asarray(Image.open(folder / "forces.png").convert("RGB")).astype(int)
        assert forces.shape[0] > 800  # three panels
    assert counts["1e5"] == 0 and counts["1e-3"] > 200
