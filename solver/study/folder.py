"""The folder of a study: what it was made from, one file for each finished case, what it leaves."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from solver.errors import SceneError
from solver.run.folders import REPORT, hold_folder, make_folder, unusable_is_refused
from solver.scene.reader import differing
from solver.study.tables import write

SETTINGS, CASES = "settings.json", "cases"

FILES = "files"
"""Key of the settings for digests of the files that they name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyFolder:
    """What a kind of study leaves in its folder; `--force` removes these, nothing else.

    Attributes:
        kind: The study, in one word, for errors.
        same: What a study that is resumed must have in common with the earlier one, in words.
        files: Names of its files besides the settings; may be patterns.
        folders: Names of its folders besides that of the cases.
    """

    kind: str
    same: str
    files: tuple[str, ...]
    folders: tuple[str, ...] = ()

    def claim(
        self, folder: Path, settings: Mapping[str, Any], *, force: bool, resume: bool
    ) -> None:
        """Make the folder of a study, or refuse to write over what is there.

        Args:
            folder: To be claimed.
            settings: What the study is made from; of files only what they hold counts.
            force: Remove an earlier study.
            resume: Go on with an earlier study, which must be made from the same.
        """
        allowed, digests = "an empty folder, --force, or --resume", contents(settings)
        with unusable_is_refused(folder):
            used = make_folder(folder, force=force or resume, allowed=allowed)
            hold_folder(folder)
            if resume and used:
                self._compare(folder, with_contents(settings, digests))
            else:
                self._refuse_others(folder)
                self._clear(folder)
            write(folder / SETTINGS, {**settings, FILES: digests})
            (folder / CASES).mkdir(exist_ok=True)

    def _refuse_others(self, folder: Path) -> None:
        """Refuse a folder in which folders of such names are not those of a study."""
        named = [name for name in (CASES, *self.folders) if (folder / name).exists()]
        if named and not _is_study(folder):
            got = f"{folder}, which holds {named[0]}/, but no study"
            raise SceneError("-o", got, "another folder")

    def _clear(self, folder: Path) -> None:
        """Remove an earlier study."""
        for pattern in (SETTINGS, REPORT, *self.files):
            for file in folder.glob(pattern):
                file.unlink()
        for name in (CASES, *self.folders):
            shutil.rmtree(folder / name, ignore_errors=True)

    def _compare(self, folder: Path, held: Mapping[str, Any]) -> None:
        """Refuse a folder that was made from something else than settings with what files hold."""
        try:
            earlier = dict(json.loads((folder / SETTINGS).read_text(encoding="utf-8")))
            digests = dict(earlier.pop(FILES, {}))
        except (OSError, TypeError, ValueError):
            got = f"{folder}, which holds no {self.kind}"
            raise SceneError("--resume", got, "its folder") from None
        now = json.loads(json.dumps(held))
        keys = sorted(differing(with_contents(earlier, digests), now))
        if keys:
            more = f" and {len(keys) - 1} more" if len(keys) > 1 else ""
            got = f"{folder}, made with another {keys[0]}{more}"
            raise SceneError("--resume", got, self.same)


def contents(said: Any) -> dict[str, str]:
    """Digests of what files hold that tables name, by their names; of those that can be read."""
    found: dict[str, str] = {}
    if isinstance(said, Mapping):
        name = said.get("file")
        if isinstance(name, str):
            with suppress(OSError):
                found[name] = hashlib.sha256(Path(name).read_bytes()).hexdigest()
        said = list(said.values())
    if isinstance(said, (list, tuple)):
        for value in said:
            found |= contents(value)
    return found


def with_contents(said: Any, digests: Mapping[str, str]) -> Any:
    """What tables say, with digests of files instead of their names where there are such."""
    if isinstance(said, Mapping):
        changed = {key: with_contents(value, digests) for key, value in said.items()}
        if isinstance(said.get("file"), str):
            changed["file"] = digests.get(said["file"], said["file"])
        return changed
    if isinstance(said, (list, tuple)):
        return [with_contents(value, digests) for value in said]
    return said


def _is_study(folder: Path) -> bool:
    """Whether a study has left its settings in a folder."""
    try:
        said = json.loads((folder / SETTINGS).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(said, dict) and bool({"version", FILES} & said.keys())


def finished(folder: Path) -> dict[str, dict[str, Any]]:
    """The rows of the completed cases by name; failed and damaged ones are tried again."""
    rows = {}
    for file in sorted((folder / CASES).glob("*.json")):
        try:
            row = json.loads(file.read_text(encoding="utf-8"))
        except ValueError:
            continue
        if isinstance(row, dict) and row.get("status") == "completed":
            rows[file.stem] = row
    return rows


def store(folder: Path, name: str, row: Mapping[str, Any]) -> None:
    """Keep the row of a case."""
    write(folder / CASES / f"{name}.json", row)
