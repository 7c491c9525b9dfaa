"""Every oracle holds; `make oracles` prints the table of differences."""

from __future__ import annotations

import pytest

from tests.oracles.collected import TOPICS
from tests.oracles.oracle import Oracle


def parameters() -> list[object]:
    """All oracles with their marks."""
    found = []
    for topic, oracles in TOPICS.items():
        for oracle in oracles:
            absent = not oracle.needs.exists()
            marks = [pytest.mark.skipif(absent, reason=f"no {oracle.needs}")]
            marks += [pytest.mark.slow] if oracle.slow else []
            found.append(pytest.param(oracle, id=f"{topic}: {oracle.name}", marks=marks))
    return found


@pytest.mark.serial
@pytest.mark.parametrize("oracle", parameters())
def test_oracle(oracle: Oracle) -> None:
    off = [
        f"{name}: expected {value.expected}, found {found}, {value.off(found):.3g} tolerances off"
        for name, value, found in oracle.differences()
        if value.off(found) > 1
    ]
    assert not off, "\n".join(off)


def test_names_differ() -> None:
    for topic, oracles in TOPICS.items():
        names = [oracle.name for oracle in oracles]
        assert len(set(names)) == len(names), topic
