"""Units of accelerations."""

from __future__ import annotations

G_UNIT = 9.81
"""What "g" means in amplitudes, records and tables, m/s^2, whatever the gravity of the scene is."""

UNITS = {
    "g": G_UNIT,
    "m/s2": 1.0,
    "cm/s2": 0.01,
    "mm/s2": 0.001,
    "mg": 0.001 * G_UNIT,
    "g/10": 0.1 * G_UNIT,
    "ft/s2": 0.3048,
    "in/s2": 0.0254,
}
"""In m/s^2."""
