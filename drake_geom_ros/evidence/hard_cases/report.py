"""The verdicts as tables, and as a page with versions and examples."""

from __future__ import annotations

import json
import platform
from collections import Counter
from collections.abc import Iterable

from drake_geom_ros.evidence.asking import OURS
from drake_geom_ros.evidence.hard_cases.cases import Case
from drake_geom_ros.evidence.hard_cases.judge import VERDICTS, Verdict
from drake_geom_ros.evidence.pages import table
from drake_geom_ros.evidence.peers import QUERIES, version

# By side, query and case.
Results = dict[tuple[str, str, str], Verdict]
EXAMPLES = 8  # of each peer
EXTREMES = 'extremes'  # the family of sizes that no user has
HOW = """A case passes when its distance is right within a thousandth of the smaller body's radius
(and rounding), and so are the normal and the witness points where the library gives any: the
measure is generous, for it is the same for all. Ours are held to far more by
`test/evidence/hard_cases`: the certificate, both orders, rigid motions, scales, every query and
accuracy level. `signed_distance` asks for one pair, `penetration` for contacts of the pair at the
library's own settings. python-fcl reports no normal with a distance and no witness points with a
contact.
A Solid is a mesh as the body within its surface. python-fcl and Coal are given its triangles
(BVHModel), which have no inside, and of which python-fcl tells an unsigned distance (-1 where they
are crossed); pydrake and MuJoCo are given its hull. All are held to the signed distance all the
same.
Every peer is asked in a process that may be lost: `crash` is one that ended, `hang` one that took
more than 3 s of processor time. The totals leave out the family `extremes`, sizes of 1e-324 to
1e300 m."""
REPRODUCE = """    ./run hard-cases                  # everything; writes this page
    ./run hard-cases --case H01       # one case: poses with full digits, and all answers"""


def counted(verdicts: Iterable[Verdict]) -> Counter[str]:
    """Return how often each verdict was given."""
    return Counter(verdict.verdict for verdict in verdicts)


def told(counts: Counter[str]) -> str:
    """Return counts in words, the most important first."""
    return ', '.join(f'{counts[v]} {v}' for v in VERDICTS if counts[v]) or 'nothing asked'


def tables(cases: list[Case], results: Results) -> str:
    """Return totals, and for each query who passes how much of each family, in Markdown."""
    sides = list(dict.fromkeys(name for name, _, _ in results))
    parts = [_totals(cases, results, sides)]
    for query in QUERIES:
        rows = []
        for family in dict.fromkeys(case.family for case in cases):
            ids = [case.id for case in cases if case.family == family]
            cells = [counted(results[name, query, i] for i in ids)['pass'] for name in sides]
            rows.append([family, str(len(ids)), *map(str, cells)])
        parts.append(f'Cases passed, `{query}`:\n\n' + table(['family', 'cases', *sides], rows))
    return '\n'.join(parts)


def _totals(cases: list[Case], results: Results, sides: list[str]) -> str:
    rows = []
    cases = [case for case in cases if case.family != EXTREMES]
    for query in QUERIES:
        for name in sides:
            counts = counted(results[name, query, case.id] for case in cases)
            rows.append([query, name, *(str(counts[v]) if counts[v] else '-' for v in VERDICTS)])
    return table(['query', 'library', *VERDICTS], rows)


def page(cases: list[Case], results: Results) -> str:
    """Return the page: how it is judged, the tables, examples, how to reproduce one."""
    peers = [name for name in dict.fromkeys(name for name, _, _ in results) if name != OURS]
    versions = ', '.join(f'{name} {version(name)}' for name in peers)
    parts = [
        '# Hard cases',
        f'{len(cases)} pairs of shapes that solvers fail on, from published reports and from '
        'generated families\n(`drake_geom_ros/evidence/hard_cases/catalogue`), asked of '
        f'this project and of its peers: {versions};\nPython {platform.python_version()}.',
        HOW,
        tables(cases, results),
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
