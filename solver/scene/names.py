"""Names of blocks, links and forces."""

from __future__ import annotations

import re

from solver.errors import SceneError
from solver.scene.checking import shown

LINKS = "links"
"""All links together, in the files of the fields."""

CONTACTS = "contacts"
"""All pairs of bodies that press on one another, likewise."""

# Names that mean something else in key paths, in the columns of a history, or in files of fields.
RESERVED = (
    *("foundation", "contact", "pair", "damping", "motion", "time", "output"),
    *("base", "platform", "plate", "frame", "energy", LINKS, CONTACTS),
)


def refuse_name(name: str) -> None:
    """Refuse a name that cannot stand in a key path.

    Raises:
        SceneError: Of the key `name`.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,99}", name) or name in RESERVED:
        allowed = f"a letter, then letters, digits, _, -, 100 in all; not {', '.join(RESERVED)}"
        raise SceneError("name", shown(name), allowed)
