"""Pages about runs and studies: whole, with nothing outside of them, and with the right numbers."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from html_page import Page
from made_up_runs import in_space, stack

from rockslip import parse_scene
from solver.cli import main

pytest.importorskip("matplotlib")
pytest.importorskip("pyvista")


def page_of(file: Path) -> Page:
    """A page that was read, closed and with nothing outside of it."""
    page = Page()
    page.feed(file.read_text(encoding="utf-8"))
    assert page.open == []
    assert all(source.startswith("data:image/") for source in page.sources)
    return page


def test_the_page_of_a_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = stack(tmp_path / "stack")
    summary = json.loads((folder / "summary.json").read_text())
    summary["cautions"] = ["the <mesh> is coarse"]
    (folder / "summary.json").write_text(json.dumps(summary))
    assert main(["report", str(folder), "--no-film"]) == 0
    assert capsys.readouterr().out == f"{folder / 'report.html'}\n"
    page = page_of(folder / "report.html")
    assert len(page.sources) == 7  # floor spectra among them: the stack is on a platform
    for part in ("energy: ", "Blocks", "Pictures", "Scene", "How to repeat"):
        assert part in page.text
    assert "the <mesh> is coarse" in page.text
    # 0.1 rad, and 0.04 m of slip
    assert "5.73" in page.text
    assert "39.8" in page.text or "40" in page.text
    assert "rockslip run" in page.text
    assert 'kind = "oscillator"' in page.text
    assert parse_scene((folder / "scene.toml").read_text())


def test_the_page_of_a_reference(tmp_path: Path) -> None:
    """What it does not know is none of the numbers of its file."""
    scene, folder = tmp_path / "scene.toml", tmp_path / "reference"
    scene.write_text(
        'foundation = { kind = "oscillator", mass_ratio = 2.0, period = 0.5 }\n'
        'block = [{ width = 0.25, height = 1.0, density = 2e3, tilt_deg = 3.0, model = "rigid" }]\n'
        "contact = { friction = 0.7 }\ntime = { end = 0.3 }\n"
    )
    assert main(["reference", str(scene), "-o", str(folder), "-q"]) == 0
    assert main(["report", str(folder), "--no-film"]) == 0
    assert "lost: not known" in page_of(folder / "report.html").text


@pytest.mark.slow
def test_the_film_stands_on_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is made once."""
    from solver.pictures import film
    from solver.pictures import page as run_page

    folder = in_space(tmp_path / "space")
    small = film.FilmOptions(begin=0.0, end=0.1, slow=1.0, width=320)
    calls = []

    def short(runs: list[film.Run], file: Path, options: film.FilmOptions) -> None:
        calls.append(options)
        film.film(runs, file, small)

    monkeypatch.setattr(run_page, "film", short)
    monkeypatch.setattr(run_page, "default_ending", lambda: ".gif")
    for _ in range(2):
        assert main(["report", str(folder), "-o", str(tmp_path / "page.html")]) == 0
    assert len(calls) == 1
    page = page_of(tmp_path / "page.html")
    assert sum(source.startswith("data:image/gif") for source in page.sources) == 1


def test_the_page_of_a_study(tmp_path: Path) -> None:
    from matplotlib.figure import Figure

    (tmp_path / "suite.csv").write_text(
        "motion,status,reason,pga_g\na,completed,,0.123456\nb,failed,no <file>,\n"
    )
    (tmp_path / "suite.txt").write_text("motion  PGA g\na       0.123\n")
    scene = "[[block]]\nwidth = 0.3\nheight = 1\nmass = 10\nmodel = 'rigid'\n[time]\nend = 1\n"
    command = "rockslip study suite scene.toml --vary contact.friction=0.1,0.2"
    settings = {"scene": parse_scene(scene).to_dict(), "command": command}
    (tmp_path / "settings.json").write_text(json.dumps(settings))
    Figure().savefig(tmp_path / "suite.png")
    assert main(["report", str(tmp_path)]) == 0
    page = page_of(tmp_path / "report.html")
    assert len(page.sources) == 1
    assert "0.1235" in page.text
    assert "b: failed (no <file>)" in page.text
    assert command in page.text
    assert "width = 0.3" in page.text


def test_what_is_neither_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(tmp_path)]) == 2
    assert "no scene.toml" in capsys.readouterr().err


def test_a_page_is_written_over_no_other_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Files that do not end as pages do may be the user's, or the run's: they are refused."""
    record = tmp_path / "mine.AT2"
    record.write_text("samples")
    assert main(["report", str(tmp_path), "-o", str(record), "--no-film"]) == 2
    assert f"-o: got {record}, allowed a file that ends in .html or .htm" in capsys.readouterr().err
    assert record.read_text() == "samples"
