"""Parts of HTML pages: each function returns a part, or the whole page of its parts."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

STYLE = """
body { font: 15px/1.5 Georgia, serif; color: #111; }
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2 { line-height: 1.2; } h2 { margin-top: 2.2rem; }
img, video { width: 100%; max-width: 46rem; display: block; margin: 0.5rem auto; }
figure { margin: 1.5rem 0; break-inside: avoid; } figcaption { font-size: 90%; text-align: center; }
table { border-collapse: collapse; font: 12px/1.35 sans-serif; width: 100%; }
th, td { border-bottom: 1px solid #ddd; padding: 2px 5px; text-align: right; }
th { text-align: right; border-bottom: 1px solid #444; vertical-align: bottom; }
td:last-child, th:last-child { text-align: left; } thead { display: table-header-group; }
tr { break-inside: avoid; }
.caution { border-left: 4px solid #c33; background: #fbeeee; padding: 0.2rem 0.8rem; }
pre { background: #f5f5f5; padding: 0.6rem; white-space: pre-wrap; font-size: 12px; }
@media print { body { margin: 0; max-width: none; font-size: 11pt; } table { font-size: 8pt; } }
@page { size: A4; margin: 15mm; }
""".strip()

TYPES = {
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".gif": "image/gif",
    ".mp4": "video/mp4",
}
"""Types of what is shown, by the endings of its files."""


def document(title: str, parts: Iterable[str]) -> str:
    """The page of these parts below its title."""
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{STYLE}</style>'
    body = "\n".join([f"<h1>{escape(title)}</h1>", *parts])
    return f'<!doctype html>\n<html lang="en"><head>{head}</head><body>\n{body}\n</body></html>\n'


def heading(text: str) -> str:
    """The heading of a section."""
    return f"<h2>{escape(text)}</h2>"


def paragraphs(texts: Iterable[str]) -> list[str]:
    """Paragraphs of text that may hold HTML."""
    return [f"<p>{text}</p>" for text in texts]


def figure(text: str, file: Path) -> str:
    """A picture or a film inside the page, and what it shows."""
    kind = TYPES[file.suffix.lower()]
    source = f'src="data:{kind};base64,{base64.b64encode(file.read_bytes()).decode()}"'
    if kind.startswith("video"):
        shown = f"<video controls loop muted {source}></video>"
    else:
        shown = f'<img alt="{escape(text)}" {source}>'
    return f"<figure>{shown}<figcaption>{escape(text)}</figcaption></figure>"


def table(rows: Sequence[Sequence[str]]) -> str:
    """A table of words; the first row is the heading."""
    names, *body = ([escape(word) for word in row] for row in rows)
    head = "".join(f"<th>{word}</th>" for word in names)
    lines = ["<tr>" + "".join(f"<td>{word}</td>" for word in row) + "</tr>" for row in body]
    return (
        f"<table><thead><tr>{head}</tr></thead><tbody>\n" + "\n".join(lines) + "\n</tbody></table>"
    )


def items(texts: Iterable[str]) -> str:
    """A list."""
    return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in texts) + "</ul>"


def cautions(texts: Sequence[str]) -> list[str]:
    """Cautions to the reader, in a box; nothing where there is none."""
    return [f'<div class="caution">{items(texts)}</div>'] if texts else []


def verbatim(text: str) -> str:
    """Text as it stands."""
    return f"<pre>{escape(text)}</pre>"
