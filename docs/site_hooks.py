"""Hooks of MkDocs: pages of the repository's root, links out of docs/, numbers of equations.

`CONTRIBUTING.md` and `CHANGELOG.md` become pages of the site. Links to any other file of the
repository, such as a table in benchmarks/, lead to a copy of it in the site. Numbers of equations
move to the left, where they are seen without scrolling.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[1]

PAGES = {"CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
"""Files of the root that are pages, and their names in the site."""

LINK = re.compile(r"(\]\()([^)\s#]+)((?:#[^)\s]*)?\))")
"""A link or a picture: what comes before its target, the target, what comes after it."""

NUMBERED = re.compile(r"^( {4}.*\S) {3,}(\([A-Z]\d+\))$", re.MULTILINE)
"""An equation and its number."""

COLUMN = 82
"""Column at which the number of an equation begins, if the equation is not longer."""


def in_site(target: str, source: str) -> str | None:
    """Place in the site of a file that a page links to; None for what is not in the repository.

    Both paths are relative: the target to the page, the page to the root of the repository.
    """
    path = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
    if "://" in target or path.startswith("..") or not (ROOT / path).is_file():
        return None
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    return PAGES.get(path, f"repository/{path}")


def source_of(page: str) -> str:
    """Path of a page in the repository."""
    roots = {name: root for root, name in PAGES.items()}
    return roots.get(page, f"docs/{page}")


def on_files(files: Any, config: Any) -> Any:
    """Add the pages of the root, and the files outside of docs/ that pages link to."""
    for root, name in PAGES.items():
        files.append(File.generated(config, name, content=(ROOT / root).read_text("utf-8")))
    for page in [file.src_uri for file in files if file.src_uri.endswith(".md")]:
        source = source_of(page)
        for link in LINK.finditer((ROOT / source).read_text("utf-8")):
            place = in_site(link[2], source) or ""
            if place.startswith("repository/") and files.get_file_from_path(place) is None:
                original = ROOT / place.removeprefix("repository/")
                files.append(File.generated(config, place, abs_src_path=str(original)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Lead links to places in the site, show numbers of equations, hide an empty sidebar."""
    source = source_of(page.file.src_uri)
    if page.parent is None:
        page.meta["hide"] = ["navigation"]

    def led(link: re.Match[str]) -> str:
        return f"{link[1]}{in_site(link[2], source) or link[2]}{link[3]}"

    numbered = NUMBERED.sub(lambda found: f"{found[1]:<{COLUMN}}  {found[2]}", markdown)
    return LINK.sub(led, numbered)
