"""One HTML page that holds the whole study: it needs no other file and no network."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from solver.study.inertia.codes import CODE_VALUES

STYLE = """
body { font: 15px/1.5 Georgia, serif; color: #111; }
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2 { line-height: 1.2; } h2 { margin-top: 2.2rem; }
img { width: 100%; max-width: 46rem; display: block; margin: 0.5rem auto; }
figure { margin: 1.5rem 0; break-inside: avoid; } figcaption { font-size: 90%; text-align: center; }
table { border-collapse: collapse; font: 12px/1.35 sans-serif; width: 100%; }
th, td { border-bottom: 1px solid #ddd; padding: 2px 5px; text-align: right; }
th { text-align: right; border-bottom: 1px solid #444; vertical-align: bottom; }
td:last-child, th:last-child { text-align: left; } thead { display: table-header-group; }
tr { break-inside: avoid; }
pre { background: #f5f5f5; padding: 0.6rem; white-space: pre-wrap; font-size: 12px; }
@media print { body { margin: 0; max-width: none; font-size: 11pt; } table { font-size: 8pt; } }
@page { size: A4; margin: 15mm; }
""".strip()

DEFINITION = (
    "λ is the portion of the live load that, rigidly attached to the linear structure of the same "
    "stiffness k and the same dashpot c, gives the same mean peak drift over the suite of motions. "
    "The live load of mass m<sub>L</sub> slides with friction on the structure of mass "
    "m<sub>P</sub>; the linear structure has the mass m<sub>P</sub> + λ m<sub>L</sub>.",
    "All roots between -0.5 and 1.5 are listed. The one reported is followed from λ = 1, where "
    "friction is infinite and nothing slides, as friction goes down. Negative values say that "
    "friction keeps the drift below that of the empty structure; none is clipped. Intervals are "
    "those of 90 % of resampled suites (bootstrap).",
    "The base shear has a ratio of its own, which is not λ: its mean peak over that with the whole "
    "live load fixed, and over that of the empty structure.",
)

Picture = tuple[str, Path]
"""What a picture shows, and its file."""


def page(
    *,
    title: str,
    summary: Sequence[str],
    pictures: Sequence[Picture],
    table: Sequence[Sequence[str]],
    failed: Sequence[str],
    scene: str,
    command: str,
    versions: Mapping[str, str],
) -> str:
    """The page.

    Args:
        title: Of the study.
        summary: Sentences on what was computed and found.
        pictures: In their order.
        table: Words; the first row is the heading.
        failed: What failed, in words.
        scene: Text of the scene.
        command: What repeats the study.
        versions: Of the program and what it uses, by name.
    """
    parts = [f"<h1>{escape(title)}</h1>", *_paragraphs(map(escape, summary))]
    parts += ["<h2>What λ is</h2>", *_paragraphs(DEFINITION)]
    parts += ["<h2>Pictures</h2>", *(_figure(text, file) for text, file in pictures)]
    parts += ["<h2>Numbers</h2>", _table(table)]
    if failed:
        parts += ["<h2>Runs that failed</h2>", _list(failed)]
    parts += [
        "<h2>Values of codes</h2>",
        _list([f"{v.portion:g}: {v.source}" for v in CODE_VALUES]),
    ]
    parts += ["<h2>The scene</h2>", f"<pre>{escape(scene)}</pre>"]
    parts += ["<h2>How to repeat</h2>", f"<pre>{escape(command)}</pre>"]
    parts += ["<h2>Versions</h2>", _list([f"{name} {value}" for name, value in versions.items()])]
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{STYLE}</style>'
    body = "\n".join(parts)
    return f'<!doctype html>\n<html lang="en"><head>{head}</head><body>\n{body}\n</body></html>\n'


def _paragraphs(texts: Sequence[str] | map[str]) -> list[str]:
    return [f"<p>{text}</p>" for text in texts]


def _figure(text: str, file: Path) -> str:
    """A picture inside the page."""
    data = base64.b64encode(file.read_bytes()).decode()
    image = f'<img alt="{escape(text)}" src="data:image/png;base64,{data}">'
    return f"<figure>{image}<figcaption>{escape(text)}</figcaption></figure>"


def _table(rows: Sequence[Sequence[str]]) -> str:
    heading, *body = ([escape(word) for word in row] for row in rows)
    head = "".join(f"<th>{word}</th>" for word in heading)
    lines = ["<tr>" + "".join(f"<td>{word}</td>" for word in row) + "</tr>" for row in body]
    return (
        f"<table><thead><tr>{head}</tr></thead><tbody>\n" + "\n".join(lines) + "\n</tbody></table>"
    )


def _list(items: Sequence[str]) -> str:
    return "<ul>" + "".join(f"<li>{escape(item)}</li>" for item in items) + "</ul>"
