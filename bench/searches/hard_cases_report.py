"""The verdicts as tables, and as a page with versions and examples."""

from __future__ import annotations

import json
import platform
from collections import Counter
from collections.abc import Iterable

from bench.pages import table
from truth.hard_cases.cases import Case
from truth.hard_cases.judge import VERDICTS, CaseVerdict
from truth.judging.asking import OURS
from truth.peers import QUERIES, version

# By side, query and case.
Results = dict[tuple[str, str, str], CaseVerdict]
EXAMPLES = 8  # of each peer
EXTREMES = 'extremes'  # the family of sizes that no user has
HOW = """A case passes when its distance is right within a thousandth of the smaller body's radius
(and rounding), and so are the normal and the witness points where the library gives any. This is
generous, and the same for all. `test/hard_cases` requires far more of this project: the
certificate, both orders of the bodies, rigid motions, scales, every query and accuracy level.

`signed_distance` asks for one pair, `penetration` for the contacts of the pair at the library's
own settings. python-fcl reports no normal with a distance and no witness points with a contact.

A Solid is a mesh that counts as the body within its surface. python-fcl and Coal get its triangles
(BVHModel), which have no inside. python-fcl gives an unsigned distance to them (-1 where they are
crossed). pydrake and MuJoCo get its hull. All are compared with the signed distance.

Rounding of a pose may hide whether two solids that fit each other exactly touch or interlock. This
project then reports a separating translation, with a bound that holds the truth and the method
`OPEN`. That counts as wrong here.

Every library is asked in a process that may be lost: `crash` is a process that ended, `hang` one
that took more than 3 s of processor time. The totals leave out the family `extremes`."""
# What a family is, in the order of the alphabet.
FAMILIES = {
    'concentric': 'bodies with a common centre, in the same orientation or turned',
    'extremes': 'sizes from 1e-324 to 1e300 m, which no user has',
    'far': 'bodies 1 km to 10 000 km from the origin',
    'flush': 'aligned bodies face on face, so that a whole area touches',
    'fuzzed': 'pairs that random search has found',
    'half_spaces': 'every shape above, on, in and below a tilted plane',
    'hulls': 'hulls with hidden structure: boxes, coplanar and double points, prisms',
    'hunted': 'pairs that the [hunt](accuracy/hunt.md) has found',
    'lattice': 'equal sizes on the points of a lattice, axes aligned or turned by right angles',
    'nested': 'a small body within a large one, near its surface or deep',
    'parallel': 'axes parallel, or off by 1e-16 to 1e-3 rad, side by side or end to end',
    'points': 'spheres of radius 0: at centres, on surfaces, at corners, next to them',
    'ratios': 'a body of 1e-2 to 1e-8 m beside a large one',
    'reports': 'from published bug reports of FCL, Drake, Coal, MuJoCo, MoveIt and others',
    'rotations': 'rotation matrices that are off orthogonal by rounding, or by a little more',
    'same': 'a body and its copy, at the same pose or next to it',
    'slivers': 'plates, wires and pancakes, down to a ten-thousandth of their size',
    'solids': 'meshes as solids: holes, cavities, walls, and what fits into them',
    'interlocked': 'solids in slots and in line with others, to the last bits; polycubes',
    'touching': 'faces, edges and vertices at contact, or within a millimetre of it',
}
REPRODUCE = """    ./run hard-cases                  # everything; also writes this page
    ./run hard-cases --case H01       # one case: poses with full digits, and all answers"""


def counted(verdicts: Iterable[CaseVerdict]) -> Counter[str]:
    """Return how often each verdict was given."""
    return Counter(verdict.verdict for verdict in verdicts)


def told(counts: Counter[str]) -> str:
    """Return counts in words, the most important first."""
    return ', '.join(f'{counts[v]} {v}' for v in VERDICTS if counts[v]) or 'nothing asked'


def tables(cases: list[Case], results: Results) -> str:
    """Return totals, and for each query who passes how much of each family, in Markdown."""
    return f'{_totals(cases, results, sides(results))}\n{by_family(cases, results)}'


def sides(results: Results) -> list[str]:
    """Return the names of those who were asked, in order."""
    return list(dict.fromkeys(name for name, _, _ in results))


def conclusion(cases: list[Case], results: Results) -> str:
    """Return in a sentence how many cases each library solves, of usual size."""
    usual = [case for case in cases if case.family != EXTREMES]
    passed = {
        name: counted(results[name, 'signed_distance', case.id] for case in usual)['pass']
        for name in sides(results)
    }
    peers = ', '.join(f'{name} {n}' for name, n in passed.items() if name != OURS)
    return (
        f'Of {len(usual)} hard cases of usual size, this project solves {passed[OURS]} '
        f'(signed distance)' + (f'; of the same cases, {peers}.' if peers else '.')
    )


def by_family(cases: list[Case], results: Results) -> str:
    """Return for each query who passes how much of each family, in Markdown."""
    parts = []
    asked = sides(results)
    for query in QUERIES:
        rows = []
        for family in dict.fromkeys(case.family for case in cases):
            ids = [case.id for case in cases if case.family == family]
            cells = [counted(results[name, query, i] for i in ids)['pass'] for name in asked]
            rows.append([family, str(len(ids)), *map(str, cells)])
        parts.append(f'Cases passed, `{query}`:\n\n' + table(['family', 'cases', *asked], rows))
    return '\n'.join(parts)


def _totals(cases: list[Case], results: Results, asked: list[str]) -> str:
    rows = []
    cases = [case for case in cases if case.family != EXTREMES]
    for query in QUERIES:
        for name in asked:
            counts = counted(results[name, query, case.id] for case in cases)
            rows.append([query, name, *(str(counts[v]) if counts[v] else '-' for v in VERDICTS)])
    return table(['query', 'library', *VERDICTS], rows)


def page(cases: list[Case], results: Results) -> str:
    """Return the page: how it is judged, the tables, examples, how to reproduce one."""
    peers = [name for name in sides(results) if name != OURS]
    versions = ', '.join(f'{name} {version(name)}' for name in peers)
    parts = [
        '# Hard cases',
        f'{conclusion(cases, results)}\n\nThe {len(cases)} cases are pairs of shapes on which '
        'solvers fail, from published reports and from generated\nfamilies '
        f'(`test/truth/hard_cases/catalogue`). Asked were {versions};\n'
        f'Python {platform.python_version()}.',
        _totals(cases, results, sides(results)),
        '## How it is judged',
        HOW,
        '## Families',
        table(
            ['family', 'cases', 'what it is'],
            [
                [f'`{name}`', sum(case.family == name for case in cases), FAMILIES[name]]
                for name in dict.fromkeys(case.family for case in cases)
            ],
        ),
        by_family(cases, results),
        '## Worst examples',
        *(examples(name, cases, results) for name in peers),
        '## To reproduce',
        REPRODUCE,
    ]
    return '\n\n'.join(part.rstrip('\n') for part in parts) + '\n'


def examples(name: str, cases: list[Case], results: Results) -> str:
    """Return a peer's worst, one a family: crashes, hangs, NaN, then what is most off."""
    failed = [
        (case, query, results[name, query, case.id])
        for case in cases
        for query in QUERIES
        if case.family != EXTREMES
        and results[name, query, case.id].verdict not in ('pass', 'unsupported')
    ]
    order = ('crash', 'hang', 'NaN', 'exception', 'wrong')
    failed.sort(key=lambda f: (order.index(f[2].verdict), -f[2].excess))
    chosen, seen = [], set()
    for case, query, verdict in failed:
        if (verdict.verdict, case.family) not in seen and len(chosen) < EXAMPLES:
            seen.add((verdict.verdict, case.family))
            text = f'{verdict.verdict} {verdict.text}'.strip()
            kinds = f'{case.a.kind}, {case.b.kind}'
            chosen.append([case.id, case.source, f'{kinds}: {case.about}', query, text])
    headings = ['case', 'source', 'what', 'query', name]
    return table(headings, chosen) if chosen else f'{name}: none.\n'


def failures(cases: list[Case], results: Results) -> str:
    """Return what peers return today, by case, peer and query, where it is not right."""
    entries: dict[str, dict[str, dict[str, str]]] = {}
    for (name, query, identity), verdict in results.items():
        if name != OURS and verdict.verdict not in ('pass', 'unsupported'):
            text = f'{verdict.verdict} {verdict.text}'.strip()
            entries.setdefault(identity, {}).setdefault(name, {})[query] = text
    order = [case.id for case in cases if case.id in entries]
    lines = [f' {json.dumps(i)}: {json.dumps(entries[i])}' for i in order]
    return '{\n' + ',\n'.join(lines) + '\n}\n'
