"""Draw docs/pictures/architecture.png: the packages of the program and their imports.

    ./in-env python3 docs/draw_architecture.py

`imports` and `upward` are also what tests/unit/test_architecture.py judges the tree by.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

ORDER = (
    "geometry",
    "scene",
    "excitation",
    "kernels",
    "law",
    "scheme",
    "history",
    "bodies",
    "contact",
    "stepping",
    "rigid",
    "build",
    "fields",
    "results",
    "reference",
    "run",
    "pictures",
    "study",
    "cli",
)
"""Packages from the top down: each imports only from itself and from those before it."""

SHARED = frozenset({"arguments", "errors", "info", "parallel", "resumable", "types"})
"""Modules at the root of `solver/` that every package may use."""


def modules() -> dict[str, Path]:
    """All modules of the program by their dotted names."""
    files = [*ROOT.glob("geometry/**/*.py"), *ROOT.glob("solver/**/*.py"), ROOT / "rockslip.py"]
    named = {}
    for file in sorted(files):
        parts = file.relative_to(ROOT).with_suffix("").parts
        named[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return named


def _imported(tree: ast.AST, known: dict[str, Path], *, lazy: bool) -> Iterator[str]:
    """Modules of the program that a syntax tree imports; `lazy`: inside functions, too."""
    body = ast.walk(tree) if lazy else ast.iter_child_nodes(tree)
    for node in body:
        if isinstance(node, ast.ImportFrom) and node.module in known:
            inner = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from (name if name in known else node.module for name in inner)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in known)


def imports(*, lazy: bool = False) -> dict[str, set[str]]:
    """For each module the modules of the program that it imports, itself left out."""
    known = modules()
    return {
        name: set(_imported(ast.parse(file.read_text()), known, lazy=lazy)) - {name}
        for name, file in known.items()
    }


def package_of(module: str) -> str:
    """The package that a module belongs to, as in `ORDER` or `SHARED`."""
    first, *rest = module.split(".")
    if first == "geometry":
        return first
    if first == "rockslip" or not rest or rest[0] in ("cli", "__main__"):
        return "cli"
    return rest[0]


def upward(graph: dict[str, set[str]]) -> list[str]:
    """Imports that point up: from a package to one that stands below it in `ORDER`."""
    place = {package: number for number, package in enumerate(ORDER)}
    found = []
    for module, targets in graph.items():
        own = package_of(module)
        for target in targets:
            other = package_of(target)
            if other in SHARED or target == "solver":
                continue
            if place.get(other, 0) > place.get(own, -1):
                found.append(f"{module} -> {target}")
    return sorted(found)


def circles(graph: dict[str, set[str]]) -> list[str]:
    """Circles of imports, each as the chain of its modules."""
    state: dict[str, int] = {}
    chain: list[str] = []
    found: list[str] = []

    def visit(module: str) -> None:
        state[module] = 1
        chain.append(module)
        for target in sorted(graph[module]):
            if state.get(target) == 1:
                found.append(" > ".join([*chain[chain.index(target) :], target]))
            elif target not in state:
                visit(target)
        chain.pop()
        state[module] = 2

    for module in sorted(graph):
        if module not in state:
            visit(module)
    return found


def arrows() -> Counter[tuple[str, str]]:
    """Numbers of imports that lead from one package to another."""
    counted: Counter[tuple[str, str]] = Counter()
    for module, targets in imports(lazy=True).items():
        for target in targets:
            pair = package_of(module), package_of(target)
            if pair[0] != pair[1] and not SHARED & set(pair) and target != "solver":
                counted[pair] += 1
    return counted


def draw(file: Path) -> None:
    """Draw the imports as a matrix: the row's package imports the column's."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    sizes: Counter[str] = Counter()
    lines: Counter[str] = Counter()
    for module, path in modules().items():
        sizes[package_of(module)] += 1
        lines[package_of(module)] += len(path.read_text().splitlines())
    place = {package: number for number, package in enumerate(ORDER)}
    figure, axes = plt.subplots(figsize=(9.0, 7.0))
    for (own, other), count in arrows().items():
        row, column = place[own], place[other]
        shade = 0.12 + 0.68 * min(count / 25, 1.0)
        colour = "#2c6aa0" if column < row else "#c0392b"
        axes.add_patch(
            plt.Rectangle((column - 0.5, row - 0.5), 1, 1, color=colour, alpha=shade, linewidth=0)
        )
        axes.text(column, row, str(count), ha="center", va="center", fontsize=8)
    for package, number in place.items():
        square = (number - 0.5, number - 0.5)
        axes.add_patch(plt.Rectangle(square, 1, 1, color="#d8dde2", linewidth=0))
        note = f"{sizes[package]} files, {lines[package]} lines"
        axes.text(len(ORDER) - 0.3, number, note, va="center", fontsize=8, color="#555555")
    axes.set_xticks(range(len(ORDER)), ORDER, rotation=60, ha="left", fontsize=9)
    axes.set_yticks(range(len(ORDER)), ORDER, fontsize=9)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    axes.set_xlim(-0.5, len(ORDER) - 0.5)
    axes.set_ylim(len(ORDER) - 0.5, -0.5)
    axes.set_aspect("equal")
    axes.set_xlabel("imported package: the row's package imports it so many times", fontsize=9)
    for side in axes.spines.values():
        side.set_visible(False)
    figure.savefig(file, dpi=130, bbox_inches="tight")
    plt.close(figure)


if __name__ == "__main__":
    draw(ROOT / "docs" / "pictures" / "architecture.png")
