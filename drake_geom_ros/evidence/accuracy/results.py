"""What was measured, in numbers: one record for a case, a query, a library and its setting."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from drake_geom_ros.evidence.accuracy.peer_process import ANSWERED
from drake_geom_ros.evidence.hard_cases.cases import Case
from drake_geom_ros.evidence.laws import WIDE
from drake_geom_ros.evidence.tolerances import EPS, ROUNDING, TRUTH_ROUNDING

OURS = 'drake_geom_ros'


@dataclass(frozen=True)
class Setting:
    """A library and how it was set: our level, or a peer's tolerance."""

    library: str
    label: str


@dataclass
class Measured:
    """Errors and times of one setting on one case.

    ``errors``, ``bounds`` [m] (ours only) and ``sizes`` [m] go together, one entry an answer, and
    so does ``promised``: whether the bound must be as narrow as the level says;
    ``verdicts`` counts all outcomes. ``whole`` and ``inside`` are seconds a pair: with all that a
    call costs, and of the computation alone as far as that can be told.
    """

    case: str
    family: str
    query: str
    setting: Setting
    errors: list[float] = field(default_factory=list)
    bounds: list[float] = field(default_factory=list)
    sizes: list[float] = field(default_factory=list)
    configurations: list[str] = field(default_factory=list)
    wide: list[bool] = field(default_factory=list)
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
        self.errors.append(abs(distance - sample.distance))
        self.sizes.append(sample.extent)
        self.configurations.append(sample.about)
        if error_bound is not None:
            self.bounds.append(error_bound)
            self.wide.append(is_wide)

    @property
    def failures(self) -> dict[str, int]:
        """How often there was no answer, by why."""
        return {verdict: n for verdict, n in self.verdicts.items() if verdict != ANSWERED and n}

    def error(self, quantile: float) -> float:
        """Return a quantile of the errors [m]; NaN without any."""
        return float(np.quantile(self.errors, quantile)) if self.errors else float('nan')

    def worst_bound(self) -> float:
        """Return the largest error bound [m]; NaN without any."""
        return max(self.bounds, default=float('nan'))

    def worst_configuration(self) -> str:
        """Return the configuration of the worst error."""
        return self.configurations[int(np.argmax(self.errors))] if self.errors else ''

    def rounding(self) -> float:
        """Return the spacing of floats at the largest pair [m], below which no error is drawn."""
        return EPS * max(self.sizes, default=1.0)

    def ratios(self) -> list[float]:
        """Return bound over error of the answers whose error is more than rounding."""
        return [
            bound / error
            for bound, error, size in zip(self.bounds, self.errors, self.sizes, strict=False)
            if error > ROUNDING * size
        ]

    def lies(self) -> list[str]:
        """Return what is not as certified or promised, one sentence an answer."""
        found = []
        columns = self.errors, self.bounds, self.sizes, self.configurations, self.wide
        for error, bound, size, configuration, is_wide in zip(*columns, strict=False):
            where = f'{self.case}, {self.query}, {self.setting.label}, {configuration}'
            if error > bound + TRUTH_ROUNDING * size:
                found.append(f'{where}: error {error:.3g} m, error_bound {bound:.3g} m')
            if is_wide:
                found.append(f'{where}: error_bound {bound:.3g} m, {WIDE}')
        return found
