"""The node's status on /diagnostics: rate, delay, refusals, stale frames, memory."""

from __future__ import annotations

import math
import resource
import threading
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from drake_geom_ros.common.counting import counted, were
from drake_geom_ros.geometry import kernel_state
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.outputs.cycle import Cycle
from drake_geom_ros.live.scene.pose_ages import UnknownAges
from drake_geom_ros.live.scene.waiting import Waiting
from drake_geom_ros.ros.outputs.service_answers import CallCounts

if TYPE_CHECKING:  # a node that asks for no second opinion loads nothing of it
    from drake_geom_ros.live.outputs.cross_check import CrossCheckCounts

_REASON_LENGTH = 120
_KINDS_OF_REASONS = 50
_SHOWN_REASONS = 5
_NAMES_IN_MESSAGE = 5
_NAMES_IN_VALUE = 50
_LONG_LAG = 0.1  # [s] in which what moves at 1 m/s moves as far as it is to be kept away
_STATM = Path('/proc/self/statm')


class SceneStatus(NamedTuple):
    """The state of the scene for the status."""

    version: int
    ages: dict[str, float]  # [s] of all frames' poses by name
    waiting: Waiting
    filter_owners: dict[int, str]  # of the active transient filters, by id
    unknown_ages: UnknownAges = UnknownAges([])
    clock_jumps: int = 0
    filter_leases: Mapping[int, float] = MappingProxyType({})  # [s] that are left, by id
    rules: str = 'none'  # the proximity rules, in words


class Diagnostics:
    """Counts what comes in and what is refused, and makes the status message of it.

    Inputs are counted from several threads.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._lock = threading.Lock()
        self._taken = 0
        self._refused: Counter[str] = Counter()
        self._reasons: Counter[str] = Counter()
        self._latest = 'none'
        self._delays: list[float] = []
        self._lags: list[float] = []
        self._most_together = 0
        self._passed_over = 0
        self._passed_over_before = 0
        self._unanswered_before = 0
        self._last = (0.0, 0)

    def take(self, delay: float, messages: int = 1, passed_over: int = 0) -> None:
        """Count pose messages that were taken together, and answered within ``delay`` [s].

        Some of them may have been passed over, for newer ones waited behind them.
        """
        with self._lock:
            self._taken += messages - passed_over
            self._passed_over += passed_over
            self._delays.append(delay)
            self._most_together = max(self._most_together, messages)

    def answer(self, lag: float) -> None:
        """Count a cycle whose newest pose was ``lag`` [s] old at its end; inf: unknown."""
        if math.isfinite(lag):
            with self._lock:
                self._lags.append(lag)

    def refuse(self, what: str, reason: str, count: int = 1) -> None:
        """Count what was refused: messages, and transforms; ``what`` names the input."""
        key = f'{what}: {reason[:_REASON_LENGTH]}'
        with self._lock:
            self._latest = key
            self._refused[what] += count
            # The kinds of reasons are few; texts with ever new names in them must not pile up.
            if len(self._reasons) < _KINDS_OF_REASONS or key in self._reasons:
                self._reasons[key] += count

    def message(
        self, scene: SceneStatus, stale_after: float, cycle: Cycle, now: float
    ) -> DiagnosticArray:
        """Return what is to be said of now; ``now`` [s] is of any steady clock."""
        ages, waiting = scene.ages, scene.waiting
        with self._lock:
            taken, delays, self._delays = self._taken, sorted(self._delays), []
            lags, self._lags = sorted(self._lags), []
            together, self._most_together = self._most_together, 0
            passed, before = self._passed_over, self._passed_over_before
            self._passed_over_before = passed
            refused = self._refused['frame_poses']
            inputs = {f'refused from {name}': n for name, n in sorted(self._refused.items())}
            reasons, latest = self._reasons.most_common(_SHOWN_REASONS), self._latest
        stale = sorted(name for name, age in ages.items() if age > stale_after)
        status = DiagnosticStatus(name=self._name, hardware_id=self._name)
        troubles = [*filter(None, (waiting.in_words(), scene.unknown_ages.in_words()))]
        if stale:
            troubles.append(
                f'{len(stale)} of {len(ages)} frames are stale (older than {stale_after:g} s): '
                f'{some_of(stale, _NAMES_IN_MESSAGE)}'
            )
        troubles += _haste(lags, passed - before)
        status.level = DiagnosticStatus.WARN if troubles else DiagnosticStatus.OK
        status.message = '; '.join(troubles) or (
            f'{counted(cycle.count, "cycle")}, {counted(taken, "pose message")}'
        )
        elapsed, done = now - self._last[0], cycle.count - self._last[1]
        self._last = (now, cycle.count)
        values = {
            'cycles': cycle.count,
            'cycle rate [Hz]': f'{done / elapsed:.1f}' if 0.0 < elapsed < 10.0 else 'unknown',
            'delay p50 [ms]': _milliseconds(delays, 0.5),
            'delay worst [ms]': _milliseconds(delays, 1.0),
            'lag p50 [ms]': _milliseconds(lags, 0.5),
            'lag worst [ms]': _milliseconds(lags, 1.0),
            'pose messages taken': taken,
            'pose messages skipped': passed,
            'largest batch of pose messages': together,
            'pose messages refused': refused,
            'latest refusal': latest,
            'frames': len(ages),
            'stale frames': len(stale),
            'names of stale frames': some_of(stale, _NAMES_IN_VALUE),
            'oldest pose': _oldest(ages, scene.unknown_ages),
            'jumps of the clock': scene.clock_jumps,
            'frames that never had a pose': len(waiting.frames),
            'names of frames that never had a pose': some_of(waiting.frames, _NAMES_IN_VALUE),
            'pairs left out because of them': waiting.pairs,
            'transient filters': _owned(scene.filter_owners, scene.filter_leases),
            'proximity rules': scene.rules,
            'contact surfaces': cycle.contacts.told,
            'scene version': scene.version,
            'worst error bound [m]': f'{cycle.worst_error_bound:.3g}',
            'memory [MB]': f'{_memory() / 2**20:.1f}',
            'kernels': kernel_state(),
        }
        values |= inputs | {f'refused: {reason}': n for reason, n in reasons}
        status.values = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        return DiagnosticArray(status=[status])

    def add_calls(self, status: DiagnosticStatus, counts: CallCounts) -> None:
        """Add what became of calls of services; warn where some had no answer since the last."""
        figures = {
            'service calls answered': counts.answered,
            'service calls not answered': counts.unanswered,
            'service calls missed before the first one of a client': counts.before_first,
        }
        status.values += [KeyValue(key=key, value=str(n)) for key, n in figures.items()]
        lost, self._unanswered_before = (
            counts.unanswered - self._unanswered_before,
            counts.unanswered,
        )
        if lost:
            lost_calls = f'{counted(lost, "service call")} {were(lost)} not answered'
            add_trouble(status, f'{lost_calls} since the last report')


def add_counts(status: DiagnosticStatus, counts: CrossCheckCounts) -> None:
    """Add what was cross-checked to a status: one that warns where there is a disagreement."""
    values = counts._asdict().items()
    status.values += [KeyValue(key=f'cross_check {key}', value=str(n)) for key, n in values]
    if counts.disagreements:
        add_trouble(status, f'python-fcl disagrees with {counted(counts.disagreements, "answer")}')


def add_values(status: DiagnosticStatus, values: Mapping[str, str]) -> None:
    """Add values to a status."""
    status.values += [KeyValue(key=key, value=value) for key, value in values.items()]


def add_trouble(status: DiagnosticStatus, trouble: str) -> None:
    """Have a status warn of something more."""
    status.level = max(status.level, DiagnosticStatus.WARN)
    status.message += f'; {trouble}'


def _haste(lags: list[float], passed_over: int) -> list[str]:
    """Return what is wrong where more comes than can be taken; ``lags`` [s] ascend."""
    troubles = []
    if lags and (lag := _quantile(lags, 0.5)) > _LONG_LAG:
        troubles.append(
            f'half of the results were published more than {1e3 * lag:.0f} ms after the stamp '
            'of their newest pose: poses arrive late, or faster than they can be taken'
        )
    if passed_over:
        troubles.append(
            f'{counted(passed_over, "transform message")} {were(passed_over)} skipped, '
            'because more arrive than can be read; the newest of each publisher count'
        )
    return troubles


def _owned(owners: dict[int, str], leases: Mapping[int, float]) -> str:
    """Return the transient filters, who asked for them and how long they hold in words."""
    named = []
    for number, owner in owners.items():
        lease = f', lease ends in {leases[number]:.1f} s' if number in leases else ''
        named.append(f'{number} ({owner or "no owner given"}{lease})')
    return some_of(named, _NAMES_IN_VALUE) or 'none'


def _milliseconds(delays: list[float], part: float) -> str:
    """Return a quantile of ascending delays [s] in words."""
    if not delays:
        return 'none'
    return f'{1e3 * _quantile(delays, part):.3f}'


def _quantile(ascending: list[float], part: float) -> float:
    return ascending[min(len(ascending) - 1, int(part * len(ascending)))]


def _oldest(ages: dict[str, float], unknown: UnknownAges) -> str:
    """Return the name and age of the frame with the oldest pose in words."""
    if not ages:
        return 'no frames'
    name = max(ages, key=lambda n: (ages[n], n))
    if math.isinf(ages[name]):
        return f'{name}: ' + ('of unknown age' if name in unknown.frames else 'never posed')
    return f'{name}: {ages[name]:.3f} s old'


def _memory() -> int:
    """Return the bytes of memory that the process has now.

    The most it had where that cannot be read: it is not Linux, or no file may be opened any more.
    """
    try:
        return int(_STATM.read_text().split()[1]) * resource.getpagesize()
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
