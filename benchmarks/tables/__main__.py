"""Make the tables and pictures that are older than the code that they speak of.

    ./in-env python3 -m benchmarks.tables [NAME ...] [--list]
    ./in-env python3 -m benchmarks.tables [NAME ...] --harmless WHY | --known-stale WHY
    ./in-env python3 -m benchmarks.tables NAME ... --made-by COMMIT

The cheapest come first. Each is recorded as soon as it is made, so that a second call goes on where
the first was stopped; studies of `rockslip` go on within. Tables of times want a machine that does
nothing else: on a busy one they are left out unless they are named.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Mapping, Sequence

from benchmarks.tables import accepted, record
from benchmarks.tables.listed import EVIDENCE
from benchmarks.tables.making import adopt, keep_needed, make
from benchmarks.tables.page import PAGE, page
from benchmarks.tables.record import Made
from benchmarks.tables.sources import digests
from benchmarks.tables.state import BUSY, State, states


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    options = _options(arguments)
    made, changes = record.read(), accepted.harmless()
    names = options.names or list(EVIDENCE)
    if options.list:
        sys.stdout.write(_told(names, states(EVIDENCE, made, changes), made))
    elif options.harmless:
        known = [] if options.names else accepted.known_stale()
        there = [name for name in names if name in made and name not in known]
        tables = [(name, made[name].code, digests(EVIDENCE[name].code)) for name in there]
        stated = accepted.state_harmless(options.harmless, tables, changes)
        print(f"{len(stated) - len(changes)} changes stated, {keep_needed(stated, made)} needed")
    elif options.known_stale:
        found, known = states(EVIDENCE, made, changes), accepted.known_stale()
        more = {n: options.known_stale for n in names if found[n].stale and n not in known}
        accepted.write_known_stale(known | more)
        PAGE.write_text(page(made, accepted.known_stale()), encoding="utf-8")
        print(f"known to be older: {', '.join(more) or 'no more'}")
    elif options.made_by:
        for name in options.names:
            adopt(name, EVIDENCE[name], options.made_by)
    elif options.page:
        PAGE.write_text(page(made, accepted.known_stale()), encoding="utf-8")
    else:
        found = {} if options.names else states(EVIDENCE, made, changes)
        wanted = options.names or [name for name in names if found[name].stale]
        _make_all(sorted(wanted, key=lambda name: _minutes(name, made)), made, bool(options.names))
    return 0


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    """What the command line says."""
    parser = argparse.ArgumentParser(
        prog="python3 -m benchmarks.tables", description=(__doc__ or "").partition("\n")[0]
    )
    add = parser.add_argument
    add("names", nargs="*", metavar="NAME", help="also what is not older; default: all that are")
    add("--list", action="store_true", help="what there is, what it took, and why one is older")
    add("--harmless", metavar="WHY", help="state that what has changed is not seen in these")
    add("--known-stale", metavar="WHY", help="name those that are older as known to be so")
    add("--made-by", metavar="COMMIT", help="record the files as made by the code of a commit")
    add("--page", action="store_true", help="write docs/tables.md only")
    options = parser.parse_args(arguments)
    if unknown := [name for name in options.names if name not in EVIDENCE]:
        parser.error(f"{unknown[0]}: allowed {', '.join(EVIDENCE)}")
    if options.made_by and not options.names:
        parser.error("--made-by: got no NAME, allowed one or more")
    return options


def _make_all(names: Sequence[str], made: Mapping[str, Made], named: bool) -> None:
    """Make tables one after the other; a progress line before each."""
    left = [name for name in names if not EVIDENCE[name].outside]
    total = sum(_minutes(name, made) for name in left)
    for number, name in enumerate(left, 1):
        evidence, cost = EVIDENCE[name], _minutes(name, made)
        line = f"[{number}/{len(left)}] {name}: about {cost:.2g} of {total:.3g} processor minutes"
        if evidence.timed and not named and os.getloadavg()[0] > BUSY + (number > 1):
            print(f"{line}; left out, for the machine is busy", flush=True)
        else:
            print(line, flush=True)
            make(name, evidence)
        total -= cost
    for name in (name for name in names if EVIDENCE[name].outside):
        print(f"{name}: left out, for it needs {EVIDENCE[name].outside}")


def _minutes(name: str, made: Mapping[str, Made]) -> float:
    """Processor time of a table, as measured or about."""
    return (made[name].minutes if name in made else 0.0) or EVIDENCE[name].minutes


def _told(names: Sequence[str], found: Mapping[str, State], made: Mapping[str, Made]) -> str:
    """The list: a line for each table, and what it is older than."""
    known, lines = accepted.known_stale(), []
    for name in names:
        entry = made.get(name)
        when = f"{entry.version}, {entry.date}, {entry.commit}" if entry else "-"
        cost = f"{_minutes(name, made):.3g} min{'' if entry and entry.minutes else ' (guessed)'}"
        word = found[name].word + (" (known)" if name in known and found[name].stale else "")
        lines.append(f"{name:24} {word:32} {cost:20} {when}")
        lines += [f"    {reason}" for reason in found[name].reasons]
        lines += [f"    known: {known[name]}"] if name in known else []
        lines += (
            [f"    harmless: {', '.join(found[name].harmless)}"] if found[name].harmless else []
        )
    stale = [name for name in names if found[name].stale]
    lines.append(f"{len(stale)} of {len(names)} older than the code, {len(known)} known")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main())
