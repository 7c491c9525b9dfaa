"""The table of differences: `python3 -m tests.oracles [WORD ...] [--beside]`, `make oracles`.

WORD chooses the oracles whose topic or name has it. With --beside, the values of today are computed
by another engine, step or tolerance. The exit code is 1 where a number is off.
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from multiprocessing import get_context

from tests.oracles.collected import TOPICS, Row, rows


def line(row: Row) -> str:
    """One line of the table."""
    off, name, number, value, found = row
    shown = f"{found:.7g}" if isinstance(found, (int, float)) else str(found)[:60]
    expected = value.expected if isinstance(value.expected, str) else f"{value.expected:.7g}"
    verdict = "WRONG" if off > 1 else ""
    columns = f"{name:58} {number:42} {expected:>14} {shown:>14} {off:9.3g}"
    return f"{columns}  {value.source} {verdict}".rstrip()


def main(words: list[str], beside: bool) -> int:
    """Print the table, on all processors, and a line that sums it up with the worst number."""
    print(f"{'oracle':58} {'number':42} {'expected':>14} {'found':>14} {'diff/tol':>9}  source")
    chosen = [
        (topic, place)
        for topic, oracles in TOPICS.items()
        for place, oracle in enumerate(oracles)
        if oracle.needs.exists()
        and (not words or any(word in f"{topic}: {oracle.name}" for word in words))
    ]
    if not chosen:
        sys.exit(f"no oracle whose topic or name has {' or '.join(words)}")
    found: list[Row] = []
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        for part in pool.map(rows, *zip(*chosen, strict=True), repeat(beside)):
            found += part
            print("\n".join(map(line, part)), flush=True)
    wrong = sum(row[0] > 1 for row in found)
    print(f"\n{len(found)} numbers, {wrong} wrong; the worst:")
    print(line(max(found, key=lambda row: row[0])))
    return int(wrong > 0)


if __name__ == "__main__":
    arguments = [word for word in sys.argv[1:] if word != "--beside"]
    sys.exit(main(arguments, "--beside" in sys.argv))
