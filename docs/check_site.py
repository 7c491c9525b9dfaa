"""Check a built site: `python3 docs/check_site.py site`, which `make site` does.

Every link and picture leads to a file of the site, and to an anchor that is there; nothing that a
page needs to be shown comes from a network; and no table or list was left as plain text. Written
for the Python of the host: nothing outside of the standard library.
"""

from __future__ import annotations

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {"img": "src", "script": "src", "link": "href", "source": "src", "iframe": "src"}
"""Elements that load something to show a page, and the attribute that says what."""

LEFT = re.compile(r"^(?:- |\d+\. |\|.*\|$|#+ |```)", re.MULTILINE)
"""Beginning of a line of Markdown that should have become something else than text."""


class Page(HTMLParser):
    """Links, loaded files, anchors and paragraphs of a page."""

    def __init__(self, text: str) -> None:
        """Read the page."""
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.anchors: set[str] = set()
        self.paragraphs: list[str] = []
        self._in_paragraph = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what an element refers to."""
        values = {name: value for name, value in attrs if value is not None}
        self.anchors |= {values[name] for name in ("id", "name") if name in values}
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        if tag in LOADED and LOADED[tag] in values and values.get("rel") != "canonical":
            self.loaded.append(values[LOADED[tag]])
        if tag == "p":
            self._in_paragraph = True
            self.paragraphs.append("")

    def handle_endtag(self, tag: str) -> None:
        """Note where a paragraph ends."""
        self._in_paragraph = self._in_paragraph and tag != "p"

    def handle_data(self, data: str) -> None:
        """Note what a paragraph says."""
        if self._in_paragraph:
            self.paragraphs[-1] += data


def faults_of(folder: Path) -> list[str]:
    """Faults of a site, a line each."""
    pages = {file: Page(file.read_text(encoding="utf-8")) for file in folder.rglob("*.html")}
    faults = [] if pages else [f"{folder}: no pages"]
    for file, page in pages.items():
        name = file.relative_to(folder)
        faults += [f"{name}: loads {url}, from a network" for url in page.loaded if outside(url)]
        for url in [*page.links, *page.loaded]:
            if not outside(url) and file.name != "404.html":
                faults += [f"{name}: {fault}" for fault in faults_of_link(url, file, pages)]
        for text in page.paragraphs:
            if LEFT.search(text):
                faults.append(f"{name}: not a table or list, but text: {text[:60]!r}")
    return faults


def outside(url: str) -> bool:
    """True if an address is one of a network, or of a mail."""
    parts = urlsplit(url)
    return bool(parts.scheme or parts.netloc)


def faults_of_link(url: str, file: Path, pages: dict[Path, Page]) -> list[str]:
    """Faults of a link of a page to the site itself."""
    parts = urlsplit(url)
    target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
    if target.is_dir():
        target /= "index.html"
    if not target.is_file():
        return [f"{url} is not there"]
    if parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
        return [f"{url} has no such anchor"]
    return []


def main(arguments: list[str]) -> int:
    """Print what is wrong; 1 if anything is."""
    folder = Path(*arguments).resolve()
    faults = sorted(set(faults_of(folder)))
    count = len(list(folder.rglob("*.html")))
    lines = faults or [f"{folder.name}: {count} pages, all links and pictures are there"]
    sys.stdout.write("".join(f"{line}\n" for line in lines))
    return int(bool(faults))


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
