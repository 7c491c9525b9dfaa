"""The documents as a site: what its check finds, and what its navigation holds."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]


def _check() -> Any:
    """The script that checks a built site."""
    spec = importlib.util.spec_from_file_location("check_site", ROOT / "docs" / "check_site.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


check_site = _check()

SOUND = '<h1 id="top">A</h1><p>a - b</p><a href="b.html#end">B</a><img src="p/a%20b.png">'


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """A site of two pages and a picture without faults."""
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "a b.png").write_bytes(b"")
    (tmp_path / "a.html").write_text(SOUND)
    (tmp_path / "b.html").write_text('<a id="end" href="https://example.org">far</a>')
    return tmp_path


def test_a_sound_site_has_no_faults(site: Path) -> None:
    assert check_site.faults_of(site) == []
    assert check_site.main([str(site)]) == 0


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ('<a href="c.html">C</a>', "c.html is not there"),
        ('<a href="b.html#start">B</a>', "b.html#start has no such anchor"),
        ('<a href="#bottom">here</a>', "#bottom has no such anchor"),
        ('<img src="p/c.png">', "p/c.png is not there"),
        ('<script src="https://example.org/a.js"></script>', "from a network"),
        ('<link rel="stylesheet" href="https://example.org/a.css">', "from a network"),
        ("<p>These:\n- one\n- two</p>", "not a table or list"),
        ("<p>| a | b |\n|---|---|</p>", "not a table or list"),
    ],
)
def test_faults_are_found(site: Path, text: str, fault: str) -> None:
    (site / "a.html").write_text(SOUND + text)
    (found,) = check_site.faults_of(site)
    assert found.startswith("a.html: ") and fault in found
    assert check_site.main([str(site)]) == 1


def test_a_folder_without_pages_is_a_fault(tmp_path: Path) -> None:
    assert check_site.main([str(tmp_path)]) == 1


def test_every_page_is_in_the_navigation_once() -> None:
    """MkDocs says so, too, where it is installed."""
    listed = re.findall(r"^ +- [^:\n]+: ([\w/]+\.md)$", (ROOT / "mkdocs.yml").read_text(), re.M)
    pages = [page.name for page in (ROOT / "docs").glob("*.md")]
    assert sorted(listed) == sorted([*pages, "contributing.md", "changelog.md"])


def test_the_search_works_from_the_disk() -> None:
    """The plugin `offline` keeps its index in a script; ours stands in for what it would load."""
    settings = (ROOT / "mkdocs.yml").read_text()
    assert re.search(r"^plugins: .*\boffline\b", settings, re.MULTILINE)
    assert re.search(r"^  polyfills: \[iframe-worker\.js\]", settings, re.MULTILINE)
    assert (ROOT / "docs" / "iframe-worker.js").is_file()
