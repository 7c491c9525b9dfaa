"""Draw docs/pictures/architecture.png: the packages of the program and who imports whom.

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
    "verification",
    "study",
    "cli",
)
"""Packages from the top down: each imports only from itself and from those before it."""

SHARED = frozenset({"arguments", "compat", "errors", "info", "launcher", "parallel", "types"})
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
    """How many imports lead from one package to another."""
    counted: Counter[tuple[str, str]] = Counter()
    for module, targets in imports(lazy=True).items():
        for target in targets:
            pair = package_of(module), package_of(target)
            if pair[0] != pair[1] and not SHARED & set(pair) and target != "solver":
                counted[pair] += 1
    return counted


def draw(file: Path) -> None:
    """Draw the packages in a column, their imports as arcs: as thick as they are many."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.patches import FancyArrowPatch

    sizes = Counter(package_of(module) for module in modules())
    lines = Counter[str]()
    for module, path in modules().items():
        lines[package_of(module)] += len(path.read_text().splitlines())
    figure, axes = plt.subplots(figsize=(8.0, 10.0))
    height = {package: -number for number, package in enumerate(ORDER)}
    for package, y in height.items():
        note = f"{sizes[package]} files, {lines[package]} lines"
        box = {"boxstyle": "round,pad=0.35", "facecolor": "#eef3f8", "edgecolor": "#4a6a8a"}
        axes.text(0, y, package, ha="center", va="center", bbox=box, fontsize=10)
        axes.text(0.9, y, note, ha="left", va="center", fontsize=8, color="#555555")
    for (own, other), count in arrows().items():
        span = height[other] - height[own]
        bend = 0.45 if span > 0 else -0.45
        axes.add_patch(
            FancyArrowPatch(
                (-0.62, height[own]),
                (-0.62, height[other]),
                connectionstyle=f"arc3,rad={-abs(bend) if span > 0 else abs(bend)}",
                arrowstyle="-|>",
                mutation_scale=7,
                linewidth=0.4 + 0.12 * min(count, 20),
                color="#4a6a8a" if span > 0 else "#c0392b",
                alpha=0.55,
            )
        )
    axes.set_xlim(-6.5, 3.2)
    axes.set_ylim(-len(ORDER) + 0.3, 0.7)
    axes.axis("off")
    axes.set_title("Packages: each imports only from those above it", fontsize=11)
    figure.savefig(file, dpi=130, bbox_inches="tight")
    plt.close(figure)


if __name__ == "__main__":
    draw(ROOT / "docs" / "pictures" / "architecture.png")
