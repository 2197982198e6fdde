"""What was measured, as rows of a table: plain text and markdown."""

from __future__ import annotations

from dataclasses import dataclass

from bench.pages import three
from bench.peers.scenes import TENTH
from bench.peers.timing import Taken

LIBRARIES = ('ours', 'pydrake', 'MuJoCo', 'python-fcl', 'Coal')
HEADINGS = (
    *('scene', 'pace', 'query', *(f'{name} [us]' for name in LIBRARIES)),
    *('pydrake/ours', 'target', 'MuJoCo/ours', 'target', 'p99/mean', 'results: ours', 'pydrake'),
)
WIDTHS = (20, 7, 15, *(18,) * 5, 14, 12, 13, 11, 10, 15, 10)
# How many times faster than a peer each query is meant to be: ratios of the means.
OVER_PYDRAKE = {
    'penetration': 2.0,
    'candidates': 2.0,
    'near': 3.0,
    'all': 3.0,
    'points': 15.0,
    'has_collisions': 1.0,
}
ONE_BY_ONE = '100 Hz'  # the pace of cycles with a pause before each, beside MuJoCo alone
GROWTH = 1.2  # of a cycle's time when there are twice as many anchored boxes


def over_mujoco(query: str) -> float | None:
    """Return the same for MuJoCo, which has one query."""
    return 1.0 if query == 'penetration' else None


@dataclass(frozen=True)
class Measurement:
    """One query of one scene at one pace: what each library took, by name."""

    scene: str
    pace: str
    query: str
    taken: dict[str, Taken]

    @property
    def name(self) -> str:
        """What was measured."""
        return f'{self.scene} {self.pace} {self.query}'

    def mean(self, name: str) -> float | None:
        """Return the mean time of a library's cycle [s]; None where it did not answer."""
        return self.taken[name].mean() if name in self.taken else None

    def times(self, name: str) -> str:
        """Return the median, the mean and the 99th percentile of a library's cycle [us]."""
        taken = self.taken.get(name)
        if taken is None or taken.left_out:
            return '-'
        return ' / '.join(number(_micro(t)) for t in (taken.median(), taken.mean(), taken.worst()))

    def unevenness(self) -> float | None:
        """Return the 99th percentile of our cycles in times of their mean."""
        mean = self.mean('ours')
        return None if mean is None else (self.taken['ours'].worst() or 0.0) / mean

    def ratio(self, peer: str) -> float | None:
        """Return the peer's mean in times of ours."""
        ours, other = self.mean('ours'), self.mean(peer)
        return None if ours is None or other is None else other / ours

    def verdicts(self) -> list[tuple[str, float, float, bool]]:
        """Return (peer, bar, ratio, met) for each target that there is."""
        if self.scene.endswith(TENTH):
            return []
        bars = {'pydrake': OVER_PYDRAKE[self.query], 'MuJoCo': over_mujoco(self.query)}
        if self.pace == ONE_BY_ONE:
            del bars['pydrake']
        found = []
        for peer, bar in bars.items():
            ratio = self.ratio(peer)
            if bar is not None and ratio is not None:
                found.append((peer, bar, ratio, ratio >= bar))
        return found

    def disagreements(self) -> tuple[int, int] | None:
        """Return in how many cycles pydrake had another number of results, of how many."""
        if self.mean('ours') is None or self.mean('pydrake') is None:
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
    row = [m.scene, m.pace, m.query, *(m.times(name) for name in LIBRARIES)]
    for peer in ('pydrake', 'MuJoCo'):
        row += [number(m.ratio(peer), 'x'), verdicts.get(peer, '-')]
    return [*row, number(m.unevenness(), 'x'), *(number(value) for value in found)]


def _micro(seconds: float | None) -> float | None:
    return None if seconds is None else 1e6 * seconds


def number(value: float | None, unit: str = '') -> str:
    """Return a number with three digits, '-' for none."""
    return '-' if value is None else three(value) + unit


def text_line(row: list[str] | tuple[str, ...]) -> str:
    """Return a row of the table as text."""
    names, numbers = row[:3], row[3:]
    left = ''.join(f'{cell:{width}}' for cell, width in zip(names, WIDTHS, strict=False))
    right = zip(numbers, WIDTHS[3:], strict=True)
    return left + ''.join(f'{cell:>{width}}' for cell, width in right)


def summary(measurements: list[Measurement]) -> list[str]:
    """Return lines: how many targets are met, which are not, and where results differ."""
    verdicts = [(m, *verdict) for m in measurements for verdict in m.verdicts()]
    missed = [v for v in verdicts if not v[-1]]
    lines = [f'{len(verdicts) - len(missed)} of {len(verdicts)} targets met']
    for m, peer, bar, ratio, _ in sorted(missed, key=lambda v: v[3] / v[2]):
        lines.append(f'missed: {m.name}: {ratio:.3g}x {peer}, to be {bar:g}x')
    for m in measurements:
        differing = m.disagreements()
        # The candidates of two libraries differ with their bounds.
        if differing and differing[0] and m.query != 'candidates':
            lines.append(
                f'{m.name}: another number of results than pydrake in '
                f'{differing[0]} of {differing[1]} cycles'
            )
        for name, taken in m.taken.items():
            if taken.left_out:
                lines.append(f'{m.name}: {name} left out: {taken.left_out}')
    return lines
