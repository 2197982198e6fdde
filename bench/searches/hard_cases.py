"""The hard cases, asked of this project and of every installed peer.

    python -m bench.searches.hard_cases                    # all; three to five minutes
    python -m bench.searches.hard_cases reports lattice    # families
    python -m bench.searches.hard_cases --case H01         # one case: what everybody answers
    python -m bench.searches.hard_cases --record           # also write what peers return today

Prints the table and writes docs/hard_cases.md (``--out`` writes it elsewhere).
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

from bench.searches import hard_cases_report as report
from drake_geom_ros.cross_check.lost_process import outcomes
from truth.hard_cases.cases import (
    CATALOGUE,
    PEERS_TODAY,
    Case,
    entry_of,
    families,
    load,
)
from truth.hard_cases.judge import CaseVerdict, judged
from truth.judging.asking import OURS, asking, names
from truth.peers import QUERIES

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 3.0  # [s] of processor time for one question to a peer
COMPILING = 600.0  # [s] for one question to us: the first of a kind compiles its kernel


def arguments() -> argparse.Namespace:
    """Return the command line, checked."""
    parser = argparse.ArgumentParser(
        prog='bench.searches.hard_cases',
        description=__doc__,
        formatter_class=argparse.RawTextHelpFormatter,
    )
    known = families()
    parser.add_argument('families', nargs='*', help=f'of: {" ".join(known)}')
    parser.add_argument('--case', metavar='ID', help='show one case and all answers to it')
    parser.add_argument('--record', action='store_true', help=f'write {PEERS_TODAY.name}')
    parser.add_argument('--out', type=Path, default=ROOT / 'docs/hard_cases.md', help='page')
    given = parser.parse_args()
    for name in given.families:
        if name not in known:
            parser.error(f'no family is called {name!r}; there are: {" ".join(known)}')
    return given


def ask_all(cases: list[Case]) -> report.Results:
    """Return the verdicts by (name, query, case id), showing progress."""
    results: report.Results = {}
    for name in names():
        for query in QUERIES:
            start = time.perf_counter()
            limit = COMPILING if name == OURS else LIMIT
            for number, (case, outcome) in enumerate(outcomes(cases, asking(name, query), limit)):
                results[name, query, case.id] = judged(case, query, outcome)
                if number % 50 == 49:
                    print(f'\r{name}, {query}: {number + 1}/{len(cases)}', end='', flush=True)
            took = time.perf_counter() - start
            counts = report.counted([results[name, query, case.id] for case in cases])
            print(f'\r{name}, {query}: {report.told(counts)} ({took:.0f} s)', flush=True)
    return results


def show(identity: str) -> None:
    """Print one case and what everybody answers."""
    found = [case for case in load() if case.id == identity]
    if not found:
        raise SystemExit(f'no case is called {identity!r}; see {CATALOGUE}')
    (case,) = found
    print(json.dumps(entry_of(case), indent=1))
    for name in names():
        for query in QUERIES:
            limit = COMPILING if name == OURS else LIMIT
            for _, outcome in outcomes([case], asking(name, query), limit):
                verdict: CaseVerdict = judged(case, query, outcome)
                print(f'{name}, {query}: {verdict.verdict} {verdict.text}\n    {outcome.value}')


def main() -> None:
    """Ask, print and write."""
    given = arguments()
    if given.case:
        show(given.case)
        return
    cases = [case for name in given.families or families() for case in load(name)]
    results = ask_all(cases)
    print(report.tables(cases, results))
    given.out.write_text(report.page(cases, results))
    if given.record:
        PEERS_TODAY.write_text(report.failures(cases, results))
    print(f'written: {given.out}')


if __name__ == '__main__':
    main()
