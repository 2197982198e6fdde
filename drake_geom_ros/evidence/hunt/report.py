"""What the hunt found: entries for the catalogue, and the table of the worst ratios."""

from __future__ import annotations

import itertools

from drake_geom_ros.evidence.bodies import Pair
from drake_geom_ros.evidence.hard_cases.cases import Case
from drake_geom_ros.evidence.hunt import exact
from drake_geom_ros.evidence.hunt.judge import LAWS
from drake_geom_ros.evidence.hunt.minimising import minimised
from drake_geom_ros.evidence.hunt.search import CHAIN, WAYS, Hunt
from drake_geom_ros.evidence.hunt.starts import skew
from drake_geom_ros.evidence.pages import table
from drake_geom_ros.evidence.tolerances import SEARCH

SHOWN = 2  # pairs of shapes, the worst of each law and way, that are minimised
NOTE = """# The hunt

Written by `./run hunt`: pairs of shapes evolve, each towards breaking one of the laws that answers
are held to. A number is the worst defect that was seen over what is allowed; above 1 the law was
broken.

"""


def entries(hunt: Hunt, seed: int) -> tuple[list[Case], list[str]]:
    """Return what broke a law, minimised, and the lines that tell of what is no entry."""
    found, lines = [], []
    for law, way in itertools.product(LAWS, WAYS):
        of_law = {k: find for k, find in hunt.worst.items() if (k.law, k.way) == (law, way)}
        broken = sorted(
            (k for k in of_law if of_law[k].ratio > 1.0), key=lambda k: -of_law[k].ratio
        )
        for key in broken[:SHOWN]:
            find = of_law[key]
            pair, ratio = (find.pair, 0.0) if way == CHAIN else minimised(find.pair, law, seed)
            if ratio > 1.0:
                found.append(entry(pair, law, ratio, f'hunt-{seed}-{len(found)}', seed))
            else:
                why = 'on a chain of frames' if way == CHAIN else 'after other questions'
                lines.append(f'{law}, {key.kinds}, {why}: {find.ratio:.3g}')
    return found, lines


def entry(pair: Pair, law: str, ratio: float, name: str, seed: int) -> Case:
    """Return a pair as a pair of the catalogue, with its true distance."""
    tolerance = SEARCH * pair.extent
    tolerance += max(skew(one) * one.radius for one in (pair.a, pair.b))
    about = f'{law}: {ratio:.3g} times what is allowed'
    told = {'id': name, 'source': f'bench.hunt, seed {seed}', 'about': about}
    return Case(pair.a, pair.b, exact.distance(pair), tolerance, **told)


def summary(hunt: Hunt) -> str:
    """Return the worst of each law, in lines."""
    lines = []
    for law, way in itertools.product(LAWS, WAYS):
        of_law = {k: find for k, find in hunt.worst.items() if (k.law, k.way) == (law, way)}
        if of_law:
            key = max(of_law, key=lambda k: of_law[k].ratio)
            count = sum(n for k, n in hunt.broken.items() if (k.law, k.way) == (law, way))
            worst = of_law[key]
            lines.append(f'{law:12} {way:7} {worst.ratio:9.3g}  {key.kinds}, broken {count} times')
    return '\n'.join(lines)


def page(hunt: Hunt, command: str) -> str:
    """Return the page for the docs: a row for each pair of shapes, a column for each law."""
    rows = []
    for kinds in sorted({key.kinds for key in hunt.worst}):
        of_kinds = {k: find.ratio for k, find in hunt.worst.items() if k.kinds == kinds}
        worst = [max(0.0, *(r for k, r in of_kinds.items() if k.law == law)) for law in LAWS]
        rows.append([kinds, *(f'{ratio:.2g}' for ratio in worst)])
    broken = sum(hunt.broken.values())
    told = f'`{command}`: {hunt.judged} pairs judged, laws broken {broken} times.\n\n'
    return NOTE + told + table(('shapes', *LAWS), rows)
