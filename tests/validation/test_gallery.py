"""The gallery: its page is that of its script and scenes, and its pictures are small."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

import pytest

from rockslip import load_scene

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def gallery() -> ModuleType:
    """The script."""
    return importlib.import_module("demos.gallery.gallery")


def test_every_scene_is_on_the_page(gallery: ModuleType) -> None:
    scenes = {file.stem for file in (ROOT / "demos" / "gallery").glob("*.toml")}
    assert scenes == set(gallery.SCENES) and len(scenes) == 13
    assert PAGE.startswith(gallery.HEAD)
    for name in scenes:
        scene = load_scene(ROOT / "demos" / "gallery" / f"{name}.toml")
        assert f"## {scene.title}\n" in PAGE
        assert f"(pictures/gallery_{name}.png)" in PAGE


def test_pictures_are_small() -> None:
    pictures = list((ROOT / "docs" / "pictures").glob("gallery_*.png"))
    assert len(pictures) == 13
    assert sum(file.stat().st_size for file in pictures) < 1.0e6


@pytest.mark.slow
@pytest.mark.parametrize("name", ["triangle", "hexagon", "table", "statue", "containers"])
def test_the_script_runs(
    gallery: ModuleType, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What it says of a scene, with today's numbers, stands on the page."""
    pytest.importorskip("pyvista")
    monkeypatch.setattr(sys, "argv", ["gallery.py", name, "--output", str(tmp_path)])
    gallery.main()
    assert (tmp_path / f"{name}.png").stat().st_size > 5000
    run = gallery.read_run(tmp_path / name)
    assert gallery.words(name, run) in PAGE
