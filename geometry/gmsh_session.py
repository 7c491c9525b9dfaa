"""Gmsh for a while: a model of its own, options, failures in words, and what a model holds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from solver.types import Array, Indices


class Elements(NamedTuple):
    """Cells or facets of one kind in a model."""

    name: str
    """What Gmsh calls the kind."""
    nodes: Indices
    """Numbers of the nodes at their corners, in Gmsh's order, (m, k)."""


@contextmanager
def options(values: Mapping[str, float | str]) -> Iterator[None]:
    """Options of Gmsh for a while."""
    import gmsh

    def put(values: Mapping[str, float | str]) -> None:
        for name, value in values.items():
            change = gmsh.option.setString if isinstance(value, str) else gmsh.option.setNumber
            change(name, value)

    before = {
        name: (gmsh.option.getString if isinstance(value, str) else gmsh.option.getNumber)(name)
        for name, value in values.items()
    }
    try:
        put(values)
        yield
    finally:
        put(before)


@contextmanager
def silent_model(name: str) -> Iterator[Any]:
    """A new Gmsh model that says nothing; leaves no trace, also in a Gmsh that is in use."""
    import gmsh

    ours = not gmsh.isInitialized()
    if ours:
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    before = None if ours else gmsh.model.getCurrent()
    try:
        with options({"General.Terminal": 0}):
            gmsh.model.add(name)
            try:
                yield gmsh
            finally:
                gmsh.model.remove()
                if before:
                    gmsh.model.setCurrent(before)
    finally:
        if ours:
            gmsh.finalize()


@contextmanager
def failures(message: str) -> Iterator[None]:
    """Gmsh's failures as ValueErrors, whose message has Gmsh's own word in place of {}."""
    try:
        yield
    except ValueError:
        raise
    except Exception as error:  # Gmsh has no narrower class
        said = str(error).strip().splitlines() or ["no reason given"]
        raise ValueError(message.format(said[-1])) from None


def nodes_of_model() -> tuple[Array, Indices]:
    """Places of the nodes of the current model, (n, 3), and their numbers by Gmsh's tags."""
    import gmsh

    tags, places, _ = gmsh.model.mesh.getNodes()
    numbers = np.zeros(int(max(tags, default=0)) + 1, dtype=np.int64)
    numbers[tags] = np.arange(len(tags))
    return places.reshape(-1, 3), numbers


def elements_of_model(dimension: int, numbers: Indices) -> Iterator[Elements]:
    """The elements of a dimension in the current model, by the numbers of `nodes_of_model`."""
    import gmsh

    mesh = gmsh.model.mesh
    for kind, _, nodes in zip(*mesh.getElements(dimension), strict=True):
        name, _, _, count, _, corners = mesh.getElementProperties(kind)
        rows = nodes.astype(np.int64).reshape(-1, count)[:, :corners]
        yield Elements(name, numbers[rows])
