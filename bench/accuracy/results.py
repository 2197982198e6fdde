"""What was measured, in numbers: one record for a case, a query, a library and its setting.

``measurements.csv`` has all of them, for programs.
"""

from __future__ import annotations

import csv
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bench.accuracy.peer_process import ANSWERED
from truth.hard_cases.cases import Case
from truth.judging.laws import WIDE
from truth.tolerances import EPS, ROUNDING, TRUTH_ROUNDING

OURS = 'drake_geom_ros'
COLUMNS = (
    'case', 'family', 'query', 'library', 'setting', 'answers', 'failures', 'error_median',
    'error_p99', 'error_worst', 'worst_configuration', 'error_bound_worst', 'ratio_median',
    'ratio_worst', 'seconds_per_pair', 'seconds_computing',
)  # fmt: skip


@dataclass(frozen=True)
class Setting:
    """A library and how it was set: our level, or a peer's tolerance."""

    library: str
    label: str


class Answered(NamedTuple):
    """What one answer was off by, and what about; the bound is ours only."""

    error: float  # [m]
    size: float  # [m] of the pair
    configuration: str
    bound: float | None  # [m]
    is_wide: bool  # whether that is wider than promised


@dataclass
class Measured:
    """Errors and times of one setting on one case.

    ``verdicts`` counts all outcomes. ``whole`` and ``inside`` are seconds a pair: with all that a
    call costs, and of the computation alone as far as that can be told.
    """

    case: str
    family: str
    query: str
    setting: Setting
    answers: list[Answered] = field(default_factory=list)
    verdicts: Counter[str] = field(default_factory=Counter)
    whole: float | None = None
    inside: float | None = None

    def add(
        self,
        sample: Case,
        distance: float,
        error_bound: float | None = None,
        is_wide: bool = False,
    ) -> None:
        """Take an answer in."""
        self.verdicts[ANSWERED] += 1
        error = abs(distance - sample.distance)
        self.answers.append(Answered(error, sample.extent, sample.about, error_bound, is_wide))

    @property
    def errors(self) -> list[float]:
        """All errors [m]."""
        return [answer.error for answer in self.answers]

    @property
    def bounds(self) -> list[float]:
        """All error bounds [m]."""
        return [answer.bound for answer in self.answers if answer.bound is not None]

    @property
    def failures(self) -> dict[str, int]:
        """How often there was no answer, by why."""
        return {verdict: n for verdict, n in self.verdicts.items() if verdict != ANSWERED and n}

    def error(self, quantile: float) -> float:
        """Return a quantile of the errors [m]; NaN without any."""
        return float(np.quantile(self.errors, quantile)) if self.answers else math.nan

    def worst_bound(self) -> float:
        """Return the largest error bound [m]; NaN without any."""
        return max(self.bounds, default=math.nan)

    def worst_configuration(self) -> str:
        """Return the configuration of the worst error."""
        worst = max(self.answers, key=lambda answer: answer.error, default=None)
        return worst.configuration if worst else ''

    def rounding(self) -> float:
        """Return the spacing of floats at the largest pair [m], below which no error is drawn."""
        return EPS * max((answer.size for answer in self.answers), default=1.0)

    def ratios(self) -> list[float]:
        """Return bound over error of the answers whose error is more than rounding."""
        return [
            each.bound / each.error
            for each in self.answers
            if each.bound is not None and each.error > ROUNDING * each.size
        ]

    def violations(self) -> list[str]:
        """Return what breaks a certificate or the promise, one sentence an answer."""
        found = []
        for error, size, configuration, bound, is_wide in self.answers:
            where = f'{self.case}, {self.query}, {self.setting.label}, {configuration}'
            if bound is not None and error > bound + TRUTH_ROUNDING * size:
                found.append(f'{where}: error {error:.3g} m, error_bound {bound:.3g} m')
            if is_wide:
                found.append(f'{where}: error_bound {bound:.3g} m, {WIDE}')
        return found


def write_csv(records: Sequence[Measured], path: Path) -> None:
    """Write one row a record, lengths in metres and times in seconds, all digits."""
    with path.open('w', encoding='utf-8', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(COLUMNS)
        for r in records:
            failures = ' '.join(f'{name}:{n}' for name, n in sorted(r.failures.items()))
            ratios = r.ratios()
            numbers = (
                *(r.error(q) for q in (0.5, 0.99, 1.0)),
                r.worst_configuration(),
                r.worst_bound(),
                float(np.median(ratios)) if ratios else math.nan,
                max(ratios, default=math.nan),
                math.nan if r.whole is None else r.whole,
                math.nan if r.inside is None else r.inside,
            )
            cells = ['' if isinstance(x, float) and math.isnan(x) else x for x in numbers]
            writer.writerow(
                [
                    *(r.case, r.family, r.query, r.setting.library, r.setting.label),
                    *(len(r.answers), failures, *cells),
                ]
            )
