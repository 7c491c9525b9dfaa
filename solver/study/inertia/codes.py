"""What codes of practice say about the live load that counts as inertia."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class CodeValue:
    """A portion of the live load that a code counts."""

    portion: float
    name: str
    """In pictures."""
    source: str
    """Where it stands."""


CODE_VALUES = (
    CodeValue(
        portion=0.25,
        name="storage live load",
        source="ASCE/SEI 7-22, 12.7.2, item 1 (7-10 and 7-16 alike): effective seismic weight "
        "includes at least 25 % of the floor live load in areas used for storage",
    ),
    CodeValue(
        portion=0.67,
        name="storage racks",
        source="ASCE/SEI 7-16, 15.5.3 (steel storage racks, loaded to 67 % of the rated load), and "
        "ANSI MH16.1 of the Rack Manufacturers Institute, 2.6.2 (0.67 of the product load); "
        "FEMA 460 (2005), chapter 4, reviews both",
    ),
)
