"""docs/scene.md against the specifications: every key, its default, what is allowed; examples."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import MISSING, Field, fields, is_dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import pytest

from rockslip import BlockSpec, Scene, parse_scene
from solver.run.describe import describe
from solver.scene import (
    ColumnSpec,
    ContactSpec,
    DampingSpec,
    DeckSpec,
    FrameCellsSpec,
    FrameSpec,
    FrictionSpec,
    HalfSineSpec,
    OneSineSpec,
    OscillatorSpec,
    OutputSpec,
    PlateSpec,
    RecordSpec,
    RectangularSpec,
    RickerSpec,
    RigidSpec,
    SineSpec,
    StillSpec,
    SyntheticSpec,
    TableSpec,
    TimeSpec,
)
from solver.scene.checking import key_of, shown

ROOT = Path(__file__).parents[2]
PAGE, README = ROOT / "docs" / "scene.md", ROOT / "README.md"

SECTIONS: dict[str, tuple[Any, ...]] = {
    "The scene as a whole": (Scene,),
    "`[[block]]`": (BlockSpec,),
    "Friction": (FrictionSpec,),
    "`[contact]`": (ContactSpec,),
    "`[foundation]` / `kind = \"rigid\"`": (RigidSpec,),
    "`[foundation]` / `kind = \"oscillator\"`": (OscillatorSpec,),
    "`[foundation]` / `kind = \"elastic\"`": (PlateSpec,),
    "`[foundation]` / `kind = \"frame\"`": (FrameSpec,),
    "`[foundation]` / `[foundation.deck]`": (DeckSpec,),
    "`[foundation]` / `[foundation.column]`": (ColumnSpec,),
    "`[foundation]` / `[foundation.cells]`": (FrameCellsSpec,),
    "`[damping]`": (DampingSpec,),
    "`[motion]` / `kind = \"none\"`": (StillSpec,),
    "`[motion]` / `kind = \"sine\"`": (SineSpec,),
    "`[motion]` / `kind = \"half_sine\"`, `\"one_sine\"`, `\"rectangular\"`": (
        HalfSineSpec, OneSineSpec, RectangularSpec,
    ),
    "`[motion]` / `kind = \"ricker\"`": (RickerSpec,),
    "`[motion]` / `kind = \"table\"`": (TableSpec,),
    "`[motion]` / `kind = \"record\"`": (RecordSpec,),
    "`[motion]` / `kind = \"synthetic\"`": (SyntheticSpec,),
    "`[time]`": (TimeSpec,),
    "`[output]`": (OutputSpec,),
}  # fmt: skip

SHARED = ("kind", "vertical", "second")
"""Keys that stand once for all kinds, in the table of `[foundation]` or `[motion]` itself."""

Cells = tuple[str, str, str]
"""Default, what is allowed, meaning."""


def tables() -> dict[str, dict[str, Cells]]:
    """The rows of the page, by heading and key."""
    found: dict[str, dict[str, Cells]] = {}
    above = heading = ""
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            above = heading = line[3:]
        elif line.startswith("### "):
            heading = f"{above} / {line[4:]}"
        found.setdefault(heading, {})
        row = re.fullmatch(r"\| `(\w+)` \| (.+) \| (.+) \| (.+) \|", line)
        if row:
            assert row[1] not in found[heading], f"{heading}: {row[1]} twice"
            found[heading][row[1]] = (row[2], row[3], row[4])
        elif line.startswith("|"):
            assert line in ("| key | default | allowed | meaning |", "|---|---|---|---|"), line
    return found


ROWS = tables()


def keys_of(cls: Any) -> dict[str, Field[Any]]:
    """The fields of a specification that stand in its own table, by key."""
    shared = SHARED if "kind" in {field.name for field in fields(cls)} else ()
    return {key_of(field): field for field in fields(cls) if field.name not in shared}


CASES = [
    pytest.param(heading, cls, field, id=f"{cls.__name__}.{key}")
    for heading, classes in SECTIONS.items()
    for cls in classes
    for key, field in keys_of(cls).items()
]


def types_in(hint: Any) -> Iterator[Any]:
    """The types that a hint is made of, without None."""
    origin = get_origin(hint)
    if origin in (Union, UnionType, tuple):
        for part in get_args(hint):
            yield from types_in(part)
    elif hint not in (NoneType, Ellipsis):
        yield hint


def specifications(cls: Any, found: set[Any]) -> set[Any]:
    """A specification and all that may stand inside it."""
    if cls not in found:
        found.add(cls)
        for hint in get_type_hints(cls, include_extras=True).values():
            for part in types_in(hint):
                if is_dataclass(part):
                    specifications(part, found)
    return found


def allowed(hint: Any, key: str) -> Iterator[str]:
    """What the page has to say about a type."""
    origin = get_origin(hint)
    if is_dataclass(hint):
        yield "table"
    elif origin is Literal:
        yield from (f"`{shown(word)}`" for word in get_args(hint))
    elif origin is Annotated:
        kind, rule = get_args(hint)
        if kind is int:
            yield "whole number"
        words = rule.words(key).removeprefix(f"{key} ")
        yield words if words == "a finite number" else f"`{words}`"
    else:
        yield from {bool: ("`true`", "`false`"), str: ("text",), Path: ("file",)}[hint]


def test_every_table_of_a_scene_has_its_section() -> None:
    assert specifications(Scene, set()) == {cls for part in SECTIONS.values() for cls in part}
    with_keys = {heading for heading, rows in ROWS.items() if rows}
    assert with_keys <= {*SECTIONS, "`[foundation]`", "`[motion]`"}


@pytest.mark.parametrize("heading", SECTIONS)
def test_the_keys_are_those_of_the_specification(heading: str) -> None:
    """In the same order; none missing, none that does not exist."""
    for cls in SECTIONS[heading]:
        assert list(ROWS[heading]) == list(keys_of(cls))


@pytest.mark.parametrize(("heading", "first"), [("foundation", RigidSpec), ("motion", StillSpec)])
def test_what_all_kinds_share(heading: str, first: Any) -> None:
    rows, above = ROWS[f"`[{heading}]`"], f"`[{heading}]` / `kind = "
    assert set(rows) == {field.name for field in fields(first)}  # the first kind has nothing else
    classes = [cls for name in SECTIONS if name.startswith(above) for cls in SECTIONS[name]]
    kinds = [shown(next(f.default for f in fields(cls) if f.name == "kind")) for cls in classes]
    default, words, _ = rows["kind"]
    assert words == ", ".join(f"`{kind}`" for kind in kinds)
    assert default == f"`{kinds[0]}`"
    named = [word for name in ROWS if name.startswith(above) for word in re.findall('"\\w+"', name)]
    assert named == kinds


@pytest.mark.parametrize(("heading", "cls", "field"), CASES)
def test_defaults(heading: str, cls: Any, field: Field[Any]) -> None:
    """As the code has them; what the scene fills in is said in words."""
    default = ROWS[heading][key_of(field)][0]
    if field.default is MISSING and field.default_factory is MISSING:
        assert default == "required"
    elif field.default is MISSING or field.default is None:
        assert default != "required"
    else:
        assert default == f"`{shown(field.default)}`"


@pytest.mark.parametrize(("heading", "cls", "field"), CASES)
def test_what_is_allowed(heading: str, cls: Any, field: Field[Any]) -> None:
    key = key_of(field)
    text = ROWS[heading][key][1]
    expected = {
        word
        for part in types_in(get_type_hints(cls, include_extras=True)[field.name])
        for word in allowed(part, key)
    }
    marked = {word for word in expected if word.startswith("`")}
    assert marked == set(re.findall("`[^`]+`", text))
    assert all(word in text for word in expected - marked)


def test_numbers_of_cells_are_those_that_are_filled_in() -> None:
    for heading, cls in (
        ("`[[block]]`", BlockSpec),
        ('`[foundation]` / `kind = "elastic"`', PlateSpec),
    ):
        plane, space = re.findall(r"`(\[[\d, ]+\])`", ROWS[heading]["cells"][0])
        for dimension, text in ((2, plane), (3, space)):
            assert shown(filled(cls, dimension).cells) == text


def filled(cls: Any, dimension: int) -> Any:
    """A block or a plate in a scene that says nothing of its cells."""
    block = "width = 1.0\nheight = 1.0\ndensity = 1.0\nyoung = 1.0e9\npoisson = 0.2"
    plate = 'kind = "elastic"\nthickness = 1.0'
    text = f"dimension = {dimension}\n[[block]]\n{block}\n[foundation]\n{plate}\n{block}"
    scene = parse_scene(f"{text}\n[time]\nend = 1.0\nstep = 0.1")
    return scene.blocks[0] if cls is BlockSpec else scene.foundation


def examples(page: Path) -> list[str]:
    """The indented texts of a page that are whole scenes; those with `...` are not."""
    blocks = re.findall(r"(?:^(?: {4}.*)?\n)+", page.read_text(encoding="utf-8"), re.MULTILINE)
    texts = [re.sub("^ {4}", "", block, flags=re.MULTILINE).strip() for block in blocks]
    return [text for text in texts if "[[block]]" in text and "..." not in text]


@pytest.mark.parametrize("text", [*examples(PAGE), *examples(README)])
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
    assert max(len(scene.blocks) for scene in scenes) == 2
    assert len(scenes) == 4 and len(examples(README)) == 1
    # nothing that looks like TOML is left unread
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        assert not line.startswith("```")


def test_links_of_the_page_lead_somewhere() -> None:
    text = PAGE.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)]+)\)", text):
        file, _, anchor = target.partition("#")
        page = (PAGE.parent / file).read_text(encoding="utf-8") if file else text
        headings = [line.strip("# ") for line in page.splitlines() if line.startswith("#")]
        assert not anchor or anchor in [name.lower().replace(" ", "-") for name in headings]
