"""Points and facets of PLY files (Turk, 1994), of text and binary.

No library: VTK 9.3 ends the program at some files that are cut short and reads others without a
word, and meshio 5.3 does not return from some.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from geometry.convex import triangles_of
from solver.types import Array, Indices

KINDS = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"}
KINDS |= {"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4"}
KINDS |= {"uint32": "u4", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8"}
"""Types of numpy by the names of PLY."""

TEXT = "="
"""The order of bytes of what text is made: that of this computer."""

ORDERS = {"ascii": TEXT, "binary_little_endian": "<", "binary_big_endian": ">"}
"""Order of bytes by the format."""

INDICES = ("vertex_indices", "vertex_index")
"""Names of the list of a face's points."""


class Property(NamedTuple):
    """A number, or a list of numbers, of each row of an element.

    Attributes:
        name: Such as x.
        kind: numpy's name of the type.
        length: That of the number of a list's entries; empty of a number.
    """

    name: str
    kind: str
    length: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Element:
    """A table of the file, such as the vertices."""

    name: str
    rows: int
    properties: tuple[Property, ...]


class Reader:
    """Reads what follows the head of a binary file, number after number."""

    def __init__(self, body: bytes, order: str):
        """Take the rest of the file, and its order of bytes."""
        self._body, self._order, self._at = body, order, 0

    def take(self, kind: Any, count: int) -> Any:
        """The next numbers, or rows of several kinds; ValueError where the file ends before."""
        dtype = np.dtype(kind).newbyteorder(self._order)
        part = self._body[self._at : self._at + count * dtype.itemsize]
        if len(part) < count * dtype.itemsize:
            raise ValueError("got a file that ends too early, allowed a whole one")
        self._at += len(part)
        return np.frombuffer(part, dtype)

    def lists(self, element: Element) -> dict[str, list[Array]]:
        """All rows of an element, one array a row and property."""
        found: dict[str, list[Array]] = {prop.name: [] for prop in element.properties}
        for _ in range(element.rows):
            for prop in element.properties:
                count = int(self.take(prop.length, 1)[0]) if prop.length else 1
                found[prop.name].append(self.take(prop.kind, count).astype(np.float64))
        return found

    def numbers(self, element: Element) -> dict[str, Array]:
        """All rows of an element without lists, one array a property."""
        kinds = [(prop.name, prop.kind) for prop in element.properties]
        records = self.take(kinds, element.rows)
        return {name: records[name].astype(np.float64) for name, _ in kinds}


def _as_binary(text: bytes, elements: Sequence[Element]) -> tuple[bytes, list[Element]]:
    """Numbers of a text and its elements, as a binary file of one kind of numbers has them."""
    try:
        body = np.array(text.split(), dtype=np.float64).tobytes()
    except ValueError as error:
        raise ValueError(f"got {error}, allowed numbers") from None
    kinds = [
        tuple(Property(p.name, "f8", p.length and "f8") for p in element.properties)
        for element in elements
    ]
    both = zip(elements, kinds, strict=True)
    return body, [replace(element, properties=own) for element, own in both]


def read_ply(file: Path, most: int) -> tuple[Array, Indices]:
    """Points (n, 3) and triangles (m, 3); faces with more corners are cut in fans.

    Args:
        file: The file.
        most: Faces and points that it may have, more are not even read.

    Raises:
        ValueError: no PLY file, one that is cut short, or without points; the message begins with
            what was got.
    """
    content = file.read_bytes()
    head, end, body = content.partition(b"end_header")
    if not content.startswith(b"ply") or not end:
        raise ValueError("got no head from 'ply' to 'end_header', allowed a PLY file")
    order, elements = _parsed(head.decode("ascii", "replace"))
    body = body[2:] if body.startswith(b"\r\n") else body[1:]
    if order == TEXT:
        body, elements = _as_binary(body, elements)
    reader = Reader(body, order)
    points: Array = np.zeros((0, 3))
    faces: list[Array] = []
    for element in elements:
        if element.rows > most:
            raise ValueError(f"got {element.rows} rows of '{element.name}', allowed at most {most}")
        if any(prop.length for prop in element.properties):
            lists = reader.lists(element)
            faces += next((lists[name] for name in INDICES if name in lists), [])
        else:
            columns = reader.numbers(element)
            if element.name == "vertex":
                if not {"x", "y", "z"} <= columns.keys():
                    raise ValueError(f"got points with {', '.join(columns)}, allowed x, y and z")
                points = np.stack([columns[axis] for axis in "xyz"], axis=1)
    return points, triangles_of([face.astype(np.int64) for face in faces])


def _parsed(head: str) -> tuple[str, list[Element]]:
    """Order of bytes and tables by the lines of the head."""
    order = None
    tables: list[tuple[str, int, list[Property]]] = []
    for line in head.splitlines()[1:]:
        match line.split():
            case ["format", form, _] if form in ORDERS:
                order = ORDERS[form]
            case ["element", name, rows] if rows.isdecimal():
                tables.append((name, int(rows), []))
            case ["property", "list", length, kind, name] if (
                tables and length in KINDS and kind in KINDS
            ):
                tables[-1][2].append(Property(name, KINDS[kind], KINDS[length]))
            case ["property", kind, name] if tables and kind in KINDS:
                tables[-1][2].append(Property(name, KINDS[kind]))
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise ValueError(f"got '{line[:60]}' in its head, allowed a line of a PLY file")
    if order is None:
        raise ValueError("got no format in its head, allowed ascii or binary")
    return order, [
        Element(name=name, rows=rows, properties=tuple(props)) for name, rows, props in tables
    ]
