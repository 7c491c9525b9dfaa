"""Versions of sources: digests of Python files, and of a file with all that it imports."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

#: Where the packages stand, and their names; what others import is not followed.
ROOT, PACKAGES = Path(__file__).parents[2], ("geometry", "solver")

#: An import at the left margin. Others bring nothing into a module that its functions can use: they
#: stand in functions, or for checkers of types only.
_IMPORT = re.compile(r"^from +([\w.]+) +import +(\([^)]*\)|[^\n]*)|^import +([^\n]*)", re.MULTILINE)


def digest(folders: Sequence[Path]) -> str:
    """Digest of all Python sources in some folders and below them."""
    return _digest(sorted(file for folder in folders for file in folder.rglob("*.py")))


@cache
def version_of(file: Path) -> str:
    """Digest of a file and of all files that it imports, directly or not.

    Machine code holds the functions and the constants of modules that its own module imports, and
    of no others.
    """
    return _digest(sorted(closure(file)))


def closure(file: Path) -> set[Path]:
    """A file, and all files of the packages that importing it runs."""
    packages = (parent / "__init__.py" for parent in file.parents if ROOT in parent.parents)
    found = {file, *(package for package in packages if package.is_file())}
    waiting = list(found)
    while waiting:
        new = _imported(waiting.pop()) - found
        found |= new
        waiting += new
    return found


@cache
def _imported(file: Path) -> frozenset[Path]:
    """The files of the packages that a file imports itself."""
    found: set[Path] = set()
    for module in _modules(file.read_text(encoding="utf-8")):
        parts = module.split(".")
        if parts[0] in PACKAGES:
            for k in range(1, len(parts) + 1):
                path = ROOT.joinpath(*parts[:k])
                found.update((path.with_suffix(".py"), path / "__init__.py"))
    return frozenset(file for file in found if file.is_file())


def _modules(text: str) -> Iterator[str]:
    """Names that may be of modules in the imports of a source."""
    for package, names, several in _IMPORT.findall(text):
        for item in re.findall(r"[\w.]+", re.sub(r"\bas +\w+|#[^\n]*", "", names + several)):
            yield f"{package}.{item}" if package else item


def _digest(files: Sequence[Path]) -> str:
    """Digest of the contents of files."""
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]
