"""A search that evolves pairs of shapes towards a broken promise of their answers.

Beside it solids on a lattice are put flush or nearly so, whose truth fractions tell.

    python -m bench.searches.hunt                         # ten minutes
    python -m bench.searches.hunt --rounds 20 --seed 3    # the same each time, on any machine
    python -m bench.searches.hunt --record                # also write docs/accuracy/hunt.md

What is found is minimised, printed as entries for test/truth/hard_cases/catalogue and written to
out/hunt. The exit code is 1 where a law was broken.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from bench.searches.hunting.report import (
    entries,
    page,
    page_of_solids,
    summary,
    summary_of_solids,
)
from bench.searches.hunting.search import Hunt
from bench.searches.hunting.solids import SolidHunt
from truth.hard_cases.cases import text_of

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / 'docs/accuracy/hunt.md'
SHOWING = 10.0  # [s] between lines of progress


def arguments() -> argparse.Namespace:
    """Return the command line, checked."""
    parser = argparse.ArgumentParser(
        prog='bench.searches.hunt',
        description=__doc__,
        formatter_class=argparse.RawTextHelpFormatter,
    )
    parser.add_argument('--minutes', type=float, default=10.0, help='how long to search')
    parser.add_argument('--rounds', type=int, help='generations instead of minutes')
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--record', action='store_true', help=f'write {PAGE.name}')
    parser.add_argument('--out', type=Path, default=ROOT / 'out/hunt', help='folder')
    return parser.parse_args()


def search(hunt: Hunt, solids: SolidHunt, minutes: float, rounds: int | None) -> None:
    """Let the hunts go on for their time or rounds, showing progress."""
    start = shown = time.monotonic()
    done = 0
    while done < rounds if rounds is not None else time.monotonic() - start < 60.0 * minutes:
        hunt.generation()
        solids.generation()
        done += 1
        if time.monotonic() - shown > SHOWING:
            shown = time.monotonic()
            took = shown - start
            broken = sorted({key.law for key in hunt.broken} | solids.laws_broken) or 'none'
            print(f'{took:.0f} s, {hunt.judged} pairs ({hunt.judged / took:.0f} a second), '
                  f'{solids.judged} placements of solids, '
                  f'broken: {broken}', flush=True)  # fmt: skip


def main() -> int:
    """Search, print and write."""
    given = arguments()
    hunt, solids = Hunt(given.seed), SolidHunt(given.seed)
    search(hunt, solids, given.minutes, given.rounds)
    found, lines = entries(hunt, given.seed)
    print('\n'.join([summary(hunt), *lines, *summary_of_solids(solids)]))
    print(text_of(found) if found else 'nothing found for the catalogue')
    given.out.mkdir(parents=True, exist_ok=True)
    (given.out / f'seed-{given.seed}.json').write_text(text_of(found))
    written = page(hunt, ' '.join(['./run hunt', *sys.argv[1:]])) + page_of_solids(solids)
    (given.out / 'hunt.md').write_text(written)
    if given.record:
        PAGE.write_text(written)
    return 1 if hunt.broken or solids.broken else 0


if __name__ == '__main__':
    sys.exit(main())
