"""Events of a run, and the file `events.csv` beside its history that has one in each line.

An engine that knows at which instants two bodies meet says so by meetings (`Meeting`).
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from solver.errors import SceneError
from solver.types import Array

NAME = "events.csv"
"""Name of the file."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """An instant at which a block lands, lifts off, meets another body, or loses what it has.

    Velocities are those against what it meets; nan where there is none, or it is not known.
    """

    time_s: float
    """Time, s."""
    kind: str
    """"impact", "lift-off", "flight", "landing", "collision", "carrier lost", "overturned" or
    "fell"; of a link "break", or "yield" where it flows for the first time."""
    block: str
    """Name of the block; in a collision, of the body that moves faster towards the other one."""
    meets: str
    """Name of the block that it lands on, lifts off, strikes or is linked to, or "foundation"."""
    where: str = ""
    """Corners of its bottom that land or lift off, as in `gap_left_m`, joined by "+"; name of the
    link."""
    velocity_before_m_s: float = math.nan
    """Normal velocity of these corners, or of what strikes, just before, upwards or away from what
    it meets, m/s."""
    velocity_after_m_s: float = math.nan
    """Just after, m/s."""
    angular_velocity_before_rad_s: float = math.nan
    """Angular velocity just before, positive where it leans to +x, or to +y without an x, rad/s."""
    angular_velocity_after_rad_s: float = math.nan
    """Just after, rad/s."""
    impulse_Ns: float = math.nan
    """Normal impulse, N s; of an impact without that of the weight."""
    energy_lost_J: float = math.nan
    """Energy that the impact took, J; where something deforms, that of the rotation, and of a
    collision that of the bodies as rigid ones; that of a link when it broke."""
    restitution: float = math.nan
    """Angular velocity after the impact over that before it."""
    reason: str = ""
    """Reason why that is no restitution, or not known; else empty."""
    impulse_tangential_Ns: float = math.nan
    """Magnitude of the tangential impulse, N s."""
    force_N: float = math.nan
    """Force at which a link breaks or flows, N."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Meeting:
    """Two bodies that come together at an instant, as an engine knows it."""

    time_s: float
    first: str
    second: str
    """Names of the bodies."""
    up: float
    """Upward component of the unit normal, from the second to the first."""
    approach_m_s: float
    """Normal velocity with which they come together."""
    departure_m_s: float
    """And part."""
    brought_m_s: float
    """Part of the approach that the first brings."""
    impulse_Ns: float
    """Normal."""
    impulse_tangential_Ns: float
    """Its magnitude."""
    energy_lost_J: float
    spin_rad_s: tuple[float, ...]
    """Angular velocity of the first against the second before, in space, or anticlockwise."""
    later_spin_rad_s: tuple[float, ...]
    """And after; nan where it is not known."""

    @classmethod
    def of(
        cls,
        time: float,
        names: tuple[str, str],
        normal: Array,
        impulse: Array,
        *,
        speeds: tuple[float, float, float],
        spins: tuple[Array, Array],
        lost: float | None = None,
    ) -> Meeting:
        """The meeting of two bodies by what an engine has of it.

        Args:
            time: When they meet, s.
            names: Theirs.
            normal: From the second to the first, of any length, (d,).
            impulse: On the first, (d,), N s.
            speeds: Approach, departure, and the part of the approach that the first brings, m/s.
            spins: Of the first against the second, before and after, rad/s.
            lost: Energy, J; None: that of the normal impulse.
        """
        n = normal / np.linalg.norm(normal)
        along, (approach, departure, brought) = float(impulse @ n), speeds
        spin, later = (tuple(map(float, each)) for each in spins)
        return cls(
            time_s=time,
            first=names[0],
            second=names[1],
            up=float(n[-1]),
            approach_m_s=approach,
            departure_m_s=departure,
            brought_m_s=brought,
            impulse_Ns=along,
            impulse_tangential_Ns=float(np.linalg.norm(impulse - along * n)),
            energy_lost_J=0.5 * along * (approach - departure) if lost is None else lost,
            spin_rad_s=spin,
            later_spin_rad_s=later,
        )

    @property
    def measures(self) -> dict[str, Any]:
        """What an event of the first against the second tells of it, by the names of `Event`."""
        return {
            "velocity_before_m_s": -self.approach_m_s,
            "velocity_after_m_s": self.departure_m_s,
            "impulse_Ns": self.impulse_Ns,
            "energy_lost_J": self.energy_lost_J,
            "impulse_tangential_Ns": self.impulse_tangential_Ns,
        }

    def joined(self, later: Meeting) -> Meeting:
        """This one and one of the same bodies shortly after it, as one."""
        return replace(
            self,
            approach_m_s=max(self.approach_m_s, later.approach_m_s),
            departure_m_s=later.departure_m_s,
            impulse_Ns=self.impulse_Ns + later.impulse_Ns,
            impulse_tangential_Ns=self.impulse_tangential_Ns + later.impulse_tangential_Ns,
            energy_lost_J=self.energy_lost_J + later.energy_lost_J,
            later_spin_rad_s=later.later_spin_rad_s,
        )


COLUMNS = tuple(field.name for field in fields(Event))
"""Names of the columns of the file, in their order."""

TEXTS = ("kind", "block", "meets", "where", "reason")
"""Names of the columns that hold words."""


def events_text(events: Iterable[Event]) -> str:
    """The content of events.csv; numbers have all their digits, what is not known is nan."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for event in events:
        values = [getattr(event, name) for name in COLUMNS]
        table.writerow([v if isinstance(v, str) else f"{v:.17g}" for v in values])
    return text.getvalue()


def read_events(file: Path) -> tuple[Event, ...]:
    """The events in a file.

    Raises:
        SceneError: It cannot be read.
    """
    try:
        text = file.read_text(encoding="utf-8")
        rows = csv.DictReader(text[: text.rfind("\n") + 1].splitlines())
        return tuple(
            Event(**{k: v if k in TEXTS else float(v) for k, v in row.items()})  # type: ignore[arg-type]
            for row in rows
        )
    except (OSError, ValueError, TypeError) as error:
        raise SceneError(str(file), f"{error}", "an events.csv as it was written") from error
