"""Making tables and pictures, and recording them."""

from __future__ import annotations

import datetime as dt
import io
import json
import os
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tarfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.error_runtime.machine import machine
from benchmarks.tables import accepted, record
from benchmarks.tables.listed import EVIDENCE, OWN, Evidence
from benchmarks.tables.page import PAGE, page
from benchmarks.tables.record import Made
from benchmarks.tables.sources import ROOT, Digests, digests, forget, of_bytes
from solver import VERSION

FOLDER = ROOT / "output" / "tables"
"""Where the commands leave their own folders."""

SETTINGS = "settings.json"
"""What a study that can go on leaves in its folder."""


def make(name: str, evidence: Evidence) -> None:
    """Run the commands of a table, put its files where they are kept, and record it.

    A study that was stopped goes on, unless the code has changed since.
    """
    own, code = FOLDER / name, digests(evidence.code)
    resumed = _claim(own, code, grows=evidence.grows)
    if evidence.grows and not resumed:
        for file in evidence.files:
            (ROOT / file).unlink(missing_ok=True)
    load, began, worked = os.getloadavg()[0], time.monotonic(), _processor_seconds()
    for command in evidence.commands:
        subprocess.run(_words(command, own, resumed), cwd=ROOT, check=True)
    minutes, wall = (_processor_seconds() - worked) / 60, (time.monotonic() - began) / 60
    forget()
    if digests(evidence.code) != code:
        raise SystemExit(f"{name}: the code has changed while it was made; nothing is recorded")
    for kept, left in evidence.files.items():
        if kept != left:
            shutil.copyfile(own / left, ROOT / kept)
    known = accepted.known_stale()
    if known.pop(name, ""):
        accepted.write_known_stale(known)
    keep(
        name,
        Made(
            version=VERSION,
            date=dt.datetime.now(dt.UTC).date().isoformat(),
            machine=machine(),
            commit=_commit(evidence),
            minutes=0.0 if resumed else round(minutes, 2),
            wall_minutes=0.0 if resumed else round(wall, 2),
            load=round(load, 1),
            code=code,
            files={file: of_bytes(ROOT / file) for file in evidence.files},
        ),
    )
    shutil.rmtree(own, ignore_errors=True)
    _mark(own).unlink()


def adopt(name: str, evidence: Evidence, commit: str) -> None:
    """Record files as they are as made by the code of a commit."""
    archive = _git("archive", commit)
    with TemporaryDirectory() as folder:
        with tarfile.open(fileobj=io.BytesIO(archive)) as files:
            files.extractall(folder, filter="data")
        code = digests(evidence.code, Path(folder))
        of = _git("show", "-s", "--format=%h %cs", commit).decode().split()
        before = record.read().get(name)
        made = Made(
            version=_version(Path(folder)),
            date=of[1],
            machine=before.machine if before else "",
            commit=of[0],
            minutes=before.minutes if before else 0.0,
            wall_minutes=before.wall_minutes if before else 0.0,
            load=-1.0,
            code=code,
            files={file: of_bytes(ROOT / file) for file in evidence.files},
        )
    keep(name, made)


def keep(name: str, made: Made) -> None:
    """Record that something was made; forget changes that no record needs; write the page."""
    found = {**record.read(), name: made}
    found = {known: entry for known, entry in found.items() if known in EVIDENCE}
    record.write(found)
    keep_needed(accepted.harmless(), found)
    PAGE.write_text(page(found, accepted.known_stale()), encoding="utf-8")


def keep_needed(changes: Sequence[accepted.Change], made: Mapping[str, Made]) -> int:
    """Write the stated changes that records need; how many these are."""
    recorded = [(name, entry.code) for name, entry in made.items()]
    needed = accepted.needed(changes, recorded)
    accepted.write(needed)
    return len(needed)


def _words(command: str, own: Path, resumed: bool) -> list[str]:
    """The words of a command, as they are run."""
    words = [word.replace(OWN, str(own)) for word in shlex.split(command)]
    if words[0] == "rockslip":
        goes_on = resumed and (own / SETTINGS).is_file()
        return [sys.executable, "-m", "rockslip", *words[1:], *(["--resume"] if goes_on else [])]
    return [sys.executable, *words[1:]]


def _claim(own: Path, code: Digests, *, grows: bool = False) -> bool:
    """Whether there is something to go on with that the same code has begun; else it is removed."""
    mark, text = _mark(own), json.dumps(dict(code))
    begun = grows or (own / SETTINGS).is_file()
    if begun and mark.is_file() and mark.read_text("utf-8") == text:
        return True
    shutil.rmtree(own, ignore_errors=True)
    FOLDER.mkdir(parents=True, exist_ok=True)
    mark.write_text(text, encoding="utf-8")
    return False


def _mark(own: Path) -> Path:
    """The file that says by which code a folder was begun."""
    return own.with_suffix(".code.json")


def _processor_seconds() -> float:
    """Processor time of all commands that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _commit(evidence: Evidence) -> str:
    """The commit that is checked out, with + where the sources differ; empty without git."""
    try:
        at = _git("rev-parse", "--short", "HEAD").decode().strip()
        dirty = _git("status", "--porcelain", "--", *evidence.code)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return f"{at}{'+' if dirty else ''}"


def _git(*words: str) -> bytes:
    """What git says."""
    return subprocess.run(["git", *words], cwd=ROOT, check=True, capture_output=True).stdout


def _version(root: Path) -> str:
    """Version that the code in a folder says it has; it has stood in two files."""
    pattern = re.compile(r'^VERSION = "(.+)"$', re.MULTILINE)
    files = (root / "solver" / name for name in ("__init__.py", "version.py"))
    texts = (file.read_text("utf-8") for file in files if file.is_file())
    return next((found[1] for found in map(pattern.search, texts) if found), "0")
