"""Tables of docs/scene.md and docs/output.md against the code that they come from; examples."""

from __future__ import annotations

import importlib.util
import re
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import pytest

from rockslip import Scene, parse_scene
from solver.history.table import TABLE
from solver.run.describe import describe
from solver.scene.checking import shown
from solver.scene.quantities import Number

ROOT = Path(__file__).parents[2]
PAGE, README = ROOT / "docs" / "scene.md", ROOT / "README.md"
OUTPUT = ROOT / "docs" / "output.md"
SCRIPTS = ROOT / "docs" / "python.md"  # runs as a whole in `test_python.py`
PAGES = [README, *sorted(set((ROOT / "docs").glob("*.md")) - {SCRIPTS})]

ONCE = ({"RigidSpec", "StillSpec"}, {"OneSineSpec", "RectangularSpec"})
"""Specifications without keys of their own, and those whose keys are those of a half sine."""


def _generator() -> Any:
    """The script that writes the tables."""
    spec = importlib.util.spec_from_file_location(
        "generate_tables", ROOT / "docs" / "generate_tables.py"
    )
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


generator = _generator()


def tables(page: Path) -> dict[str, str]:
    """The generated tables of a page by their names."""
    text = page.read_text(encoding="utf-8")
    return {found["name"]: found[0] for found in generator.MARKED.finditer(text)}


@pytest.mark.parametrize("page", [PAGE, OUTPUT], ids=lambda page: page.name)
def test_the_tables_are_those_that_are_generated(page: Path) -> None:
    """`make docs-tables` writes them."""
    text = page.read_text(encoding="utf-8")
    assert generator.with_tables(text) == text
    assert text.count("<!-- generated: ") == text.count(generator.END) == len(tables(page))


def specifications(hint: Any, found: set[Any]) -> set[Any]:
    """A specification and all that may stand inside it."""
    if is_dataclass(hint) and hint not in found:
        found.add(hint)
        for part in get_type_hints(hint, include_extras=True).values():
            specifications(part, found)
    elif get_origin(hint) is not Annotated:
        for part in get_args(hint):
            specifications(part, found)
    return found


def test_every_table_of_a_scene_has_its_section() -> None:
    """No specification without its keys on the page, but those that share a table."""
    named = {name.removeprefix("keys of ") for name in tables(PAGE) if "keys of" in name}
    assert named == {cls.__name__ for cls in specifications(Scene, set())} - ONCE[0] - ONCE[1]
    assert {name for name in tables(PAGE) if "kinds of" in name} == {
        "kinds of foundation",
        "kinds of motion",
    }
    half_sine = generator.generated("keys of HalfSineSpec")
    for cls in ONCE[1]:
        assert generator.generated(f"keys of {cls}") == half_sine
    for cls in ONCE[0]:
        assert generator.generated(f"keys of {cls}").count("\n") == 2  # the head alone


def test_every_kind_has_its_section() -> None:
    """In the order of the table, under a heading that names it."""
    text = PAGE.read_text(encoding="utf-8")
    for part in ("foundation", "motion"):
        (row,) = re.findall(r"\| `kind` \|.*", generator.generated(f"kinds of {part}"))
        kinds = re.findall(r'`"(\w+)"`', row.split(" | ")[2])
        section = text.split(f"\n## `[{part}]`\n")[1].split("\n## ")[0]
        headings = re.findall(r"^### `kind = .*", section, re.MULTILINE)
        assert [kind for line in headings for kind in re.findall(r'"(\w+)"', line)] == kinds


def test_every_column_is_on_the_page_of_output() -> None:
    text = "".join(tables(OUTPUT).values())
    for column in TABLE:
        assert f"| `{column.name}` | {column.unit} | {column.meaning} |" in text


@dataclass(frozen=True, kw_only=True)
class Silent:
    """A specification of which a table cannot be made."""

    length: Annotated[float, Number(above=0)]
    mass: Annotated[float, Number(above=0)] | None = None
    """Mass, kg."""


def test_a_field_that_says_too_little_is_named() -> None:
    """Without a meaning, or without a word on what happens where it is left out."""
    length, mass = fields(Silent)
    with pytest.raises(ValueError, match=r"Silent\.length: no text"):
        generator.key_row(Silent, length)
    with pytest.raises(ValueError, match=r'Silent\.mass: no "Default'):
        generator.key_row(Silent, mass)


def test_numbers_of_cells_are_those_that_are_filled_in() -> None:
    for name in ("BlockSpec", "PlateSpec"):
        (row,) = re.findall(r"\| `cells` \|.*", generator.generated(f"keys of {name}"))
        plane, space = re.findall(r"`(\[[\d, ]+\])`", row)
        for dimension, text in ((2, plane), (3, space)):
            assert shown(filled(name, dimension).cells) == text


def filled(name: str, dimension: int) -> Any:
    """A block or a plate in a scene that says nothing of its cells."""
    block = "width = 1.0\nheight = 1.0\ndensity = 1.0\nyoung = 1.0e9\npoisson = 0.2"
    plate = 'kind = "elastic"\nthickness = 1.0'
    text = f"dimension = {dimension}\n[[block]]\n{block}\n[foundation]\n{plate}\n{block}"
    scene = parse_scene(f"{text}\n[time]\nend = 1.0\nstep = 0.1")
    return scene.blocks[0] if name == "BlockSpec" else scene.foundation


def examples(page: Path) -> list[str]:
    """The indented texts of a page that are whole scenes; those with `...` are not."""
    blocks = re.findall(r"(?:^(?: {4}.*)?\n)+", page.read_text(encoding="utf-8"), re.MULTILINE)
    texts = [re.sub("^ {4}", "", block, flags=re.MULTILINE).strip() for block in blocks]
    return [text for text in texts if "[[block]]" in text and "..." not in text]


@pytest.mark.parametrize("text", [text for page in PAGES for text in examples(page)])
def test_examples_are_scenes(text: str) -> None:
    scene = parse_scene(text)
    assert describe(scene)
    assert parse_scene(scene.to_dict()) == scene


def test_there_is_an_example_of_each() -> None:
    scenes = [parse_scene(text) for text in examples(PAGE)]
    assert {scene.foundation.kind for scene in scenes} == {
        "rigid",
        "oscillator",
        "elastic",
        "frame",
    }
    assert {scene.dimension for scene in scenes} == {2, 3}
    assert max(len(scene.blocks) for scene in scenes) == 4
    assert len(scenes) == 7 and len(examples(README)) == 1
    # nothing that looks like TOML is left unread
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        assert not line.startswith("```")


def test_links_of_the_page_lead_somewhere() -> None:
    text = PAGE.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)]+)\)", text):
        file, _, anchor = target.partition("#")
        assert (PAGE.parent / file).exists()
        if not anchor:
            continue
        page = (PAGE.parent / file).read_text(encoding="utf-8") if file else text
        headings = [line.strip("# ") for line in page.splitlines() if line.startswith("#")]
        assert anchor in [name.lower().replace(" ", "-") for name in headings]
