"""What was measured, as rows of a table: plain text and markdown."""

from __future__ import annotations

from dataclasses import dataclass

from bench.peers.scenes import SPREAD, TENTH
from bench.peers.timing import Taken

LIBRARIES = ('ours', 'pydrake', 'MuJoCo', 'python-fcl', 'Coal')
HEADINGS = (
    *('scene', 'query', *(f'{name} [us]' for name in LIBRARIES)),
    *('pydrake/ours', 'bar', 'MuJoCo/ours', 'bar', 'results: ours', 'pydrake'),
)
WIDTHS = (22, 15, 11, 14, 13, 17, 12, 14, 12, 13, 11, 15, 10)
# How many times faster than a peer each query is meant to be: ratios of the medians.
PENETRATION_4X = ('spheres-200', 'spheres-1000', 'mixed-1000')
OVER_PYDRAKE = {'candidates': 5.0, 'near': 4.0, 'all': 3.0, 'points': 20.0}
GROWTH = 1.2  # of a cycle's time when there are twice as many anchored boxes


def over_pydrake(scene: str, query: str) -> float:
    """Return what pydrake's time is meant to be at least, in times of ours."""
    if query == 'penetration':
        if scene.endswith(TENTH):
            return 10.0
        return 4.0 if scene in PENETRATION_4X else 2.0
    if query == 'has_collisions':
        return 2.0 if scene.endswith(SPREAD) else 1.0
    return OVER_PYDRAKE[query]


def over_mujoco(query: str) -> float | None:
    """Return the same for MuJoCo, which has one query."""
    return 1.0 if query == 'penetration' else None


@dataclass(frozen=True)
class Measurement:
    """One query of one scene: what each library took, by name."""

    scene: str
    query: str
    taken: dict[str, Taken]

    def median(self, name: str) -> float | None:
        """Return the median time of a library's cycle [s]; None where it did not answer."""
        return self.taken[name].median() if name in self.taken else None

    def ratio(self, peer: str) -> float | None:
        """Return the peer's median in times of ours."""
        ours, other = self.median('ours'), self.median(peer)
        return None if ours is None or other is None else other / ours

    def verdicts(self) -> list[tuple[str, float, float, bool]]:
        """Return (peer, bar, ratio, met) for each bar that there is."""
        bars = {
            'pydrake': over_pydrake(self.scene, self.query),
            'MuJoCo': over_mujoco(self.query),
        }
        found = []
        for peer, bar in bars.items():
            ratio = self.ratio(peer)
            if bar is not None and ratio is not None:
                found.append((peer, bar, ratio, ratio >= bar))
        return found

    def disagreements(self) -> tuple[int, int] | None:
        """Return in how many cycles pydrake had another number of results, of how many."""
        if self.median('ours') is None or self.median('pydrake') is None:
            return None
        both = list(zip(self.taken['ours'].found, self.taken['pydrake'].found, strict=True))
        return sum(a != b for a, b in both), len(both)


def cells(measurement: Measurement) -> list[str]:
    """Return the row of a measurement, as HEADINGS says."""
    m = measurement
    verdicts = {
        peer: (f'{bar:g}x {"met" if met else "MISSED"}') for peer, bar, _, met in m.verdicts()
    }
    found = [m.taken[n].mean_found() if n in m.taken else None for n in ('ours', 'pydrake')]
    row = [m.scene, m.query, *(number(_micro(m.median(name))) for name in LIBRARIES)]
    for peer in ('pydrake', 'MuJoCo'):
        row += [number(m.ratio(peer), 'x'), verdicts.get(peer, '-')]
    return row + [number(value) for value in found]


def _micro(seconds: float | None) -> float | None:
    return None if seconds is None else 1e6 * seconds


def number(value: float | None, unit: str = '') -> str:
    """Return a number with three digits, '-' for none."""
    if value is None:
        return '-'
    if value >= 100:
        return f'{value:.0f}{unit}'
    return f'{value:.3g}{unit}'


def text_line(row: list[str] | tuple[str, ...]) -> str:
    """Return a row of the table as text."""
    names, numbers = row[:2], row[2:]
    left = ''.join(f'{cell:{width}}' for cell, width in zip(names, WIDTHS, strict=False))
    right = zip(numbers, WIDTHS[2:], strict=True)
    return left + ''.join(f'{cell:>{width}}' for cell, width in right)


def summary(measurements: list[Measurement]) -> list[str]:
    """Return lines: how many bars are met, which are not, and where results differ."""
    verdicts = [(m, *verdict) for m in measurements for verdict in m.verdicts()]
    missed = [v for v in verdicts if not v[-1]]
    lines = [f'{len(verdicts) - len(missed)} of {len(verdicts)} bars met']
    for m, peer, bar, ratio, _ in sorted(missed, key=lambda v: v[3] / v[2]):
        lines.append(f'missed: {m.scene} {m.query}: {ratio:.3g}x {peer}, to be {bar:g}x')
    for m in measurements:
        differing = m.disagreements()
        # The candidates of two libraries differ with their bounds.
        if differing and differing[0] and m.query != 'candidates':
            lines.append(
                f'{m.scene} {m.query}: another number of results than pydrake in '
                f'{differing[0]} of {differing[1]} cycles'
            )
        for name, taken in m.taken.items():
            if taken.left_out:
                lines.append(f'{m.scene} {m.query}: {name} left out: {taken.left_out}')
    return lines
