"""What the node says about itself on /diagnostics: rate, refusals, stale frames."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from drake_geom_ros.ros.live_scene import LiveScene

_REASON_LENGTH = 120


class Diagnostics:
    """Counts what comes in and what is refused, and makes the status message of it."""

    def __init__(self, name: str) -> None:
        self._name = name
        self.taken = 0
        self.refused = 0
        self._reasons: Counter[str] = Counter()
        self._last = (0.0, 0)

    def take(self) -> None:
        """Count a pose message that was taken."""
        self.taken += 1

    def refuse(self, reason: str) -> None:
        """Count a pose message that was refused."""
        self.refused += 1
        # The kinds of reasons are few; texts with ever new names in them must not pile up.
        if len(self._reasons) < 50 or reason[:_REASON_LENGTH] in self._reasons:
            self._reasons[reason[:_REASON_LENGTH]] += 1

    def message(self, live: LiveScene, stale_after: float, cycles: int, now: float) -> Any:
        """Return the DiagnosticArray of now; ``now`` [s] is of any steady clock."""
        status = DiagnosticStatus(name=self._name, hardware_id=self._name)
        ages = live.pose_ages()
        stale = sorted(name for name, age in ages.items() if age > stale_after)
        oldest, age = _worst_age(ages)
        status.level = DiagnosticStatus.OK
        status.message = f'{cycles} cycles, {self.taken} pose messages'
        if stale:
            status.level = DiagnosticStatus.WARN
            status.message = (
                f'{len(stale)} of {len(ages)} frames are stale (older than {stale_after:g} s): '
                f'{", ".join(stale[:5])}{" ..." if len(stale) > 5 else ""}'
            )
        elapsed, done = now - self._last[0], cycles - self._last[1]
        self._last = (now, cycles)
        values = {
            'cycles': cycles,
            'cycle rate [Hz]': f'{done / elapsed:.1f}' if 0.0 < elapsed < 10.0 else 'unknown',
            'pose messages taken': self.taken,
            'pose messages refused': self.refused,
            'frames': len(ages),
            'stale frames': len(stale),
            'oldest pose': f'{oldest}: {_describe_age(age)}' if oldest else 'no frames',
            'scene version': live.version,
        }
        values |= {f'refused: {reason}': n for reason, n in self._reasons.most_common(5)}
        status.values = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        return DiagnosticArray(status=[status])


def _worst_age(ages: dict[str, float]) -> tuple[str, float]:
    """Return the name and age [s] of the frame with the oldest pose; ('', 0) without frames."""
    if not ages:
        return '', 0.0
    name = max(ages, key=lambda n: (ages[n], n))
    return name, ages[name]


def _describe_age(age: float) -> str:
    """Return an age in words."""
    return 'never posed' if math.isinf(age) else f'{age:.3f} s old'
