"""Selected bodies of a page, at most two, and their distance whatever it is."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.viewing.bodies import PairDistance, ShownBody
from drake_geom_ros.viewing.shown_pairs import ReportedPairs, in_words
from drake_geom_ros.viewing.shown_scene import ShownMoment, ShownScene

_LETTERS = 'AB'
_PERIOD = 1.0  # [s] between two questions about the same filter
_ASKING = 'the filters are asked'


@dataclass(frozen=True)
class Selection:
    """Id values of the selected bodies, A first."""

    values: tuple[int, ...] = ()

    def picked(self, value: int) -> Selection:
        """Return the selection after a click on a body.

        The first click fills A, the second B, the third begins anew; a click on a selected body
        takes it out.
        """
        if value in self.values:
            return Selection(tuple(each for each in self.values if each != value))
        return Selection((value,) if len(self.values) == 2 else (*self.values, value))

    @property
    def pair(self) -> tuple[int, int] | None:
        """The two id values, the lower one first; None for fewer bodies."""
        return (min(self.values), max(self.values)) if len(self.values) == 2 else None


class SelectedBodies:
    """Texts and distance of the selected bodies of a scene."""

    def __init__(self, scene: ShownScene, touch: Callable[[], None]) -> None:
        """Show bodies of ``scene``; ``touch()`` is called when a reason for a filter came."""
        self._scene, self._touch = scene, touch
        self._distance: tuple[tuple[Any, ...], PairDistance] | None = None
        # A node may take its time to explain a filter, so another thread asks it.
        self._asking = ThreadPoolExecutor(1, thread_name_prefix='filters')
        self._pair: tuple[int, int] | None = None
        self._filter, self._due = '', 0.0

    def close(self) -> None:
        """Ask no more."""
        self._asking.shutdown(wait=False, cancel_futures=True)

    def explain_anew(self) -> None:
        """Ask again why the pair is filtered, since filters changed."""
        self._due = 0.0

    def distance(
        self, moment: ShownMoment, pair: tuple[int, int], accuracy: str
    ) -> tuple[ReportedPairs, str]:
        """Return the pair as a row, or no row and the reason why it has no distance."""
        row = moment.pairs.find(pair)
        if row is not None:
            return moment.pairs.rows(slice(row, row + 1)), ''
        bodies = [self._scene.body(value) for value in pair]
        poses = {value: moment.pose_of(value) for value in pair}
        if None in bodies or None in poses.values():
            return ReportedPairs.none(), 'no distance: a body of the pair has no pose or no shape'
        try:
            row_of_pair = self._pair_distance(bodies).between(_posed(poses), accuracy)
        except (GeometryError, OSError) as error:
            return ReportedPairs.none(), str(error)
        return row_of_pair, ''

    def _pair_distance(self, bodies: list[Any]) -> PairDistance:
        # What is registered is compared, since a body may change its shape and keep its id.
        key = tuple((body.value, id(body.shape)) for body in bodies)
        if self._distance is None or self._distance[0] != key:
            self._distance = key, PairDistance(*bodies)
        return self._distance[1]

    def plain(
        self, moment: ShownMoment, selection: Selection, accuracy: str
    ) -> tuple[dict[str, Any], ReportedPairs]:
        """Return the selection as JSON has it, and the row of its pair."""
        bodies = [
            {
                'letter': letter,
                'id': value,
                'name': moment.geometries.names.get(value, f'#{value}'),
                'rows': _rows(self._scene.body(value), moment.pose_of(value)),
            }
            for letter, value in zip(_LETTERS, selection.values, strict=False)
        ]
        plain: dict[str, Any] = {'bodies': bodies, 'pair': None}
        pair = selection.pair
        if pair is None:
            return plain, ReportedPairs.none()
        row, reason = self.distance(moment, pair, accuracy)
        plain['pair'] = {'reason': reason, 'filter': self.explanation(pair)}
        if len(row):
            plain['pair'] |= {
                'text': in_words(row, 0, bounds=True),
                'distance': float(row.distance[0]),
                'error_bound': float(row.error_bound[0]),
                'p_WCa': row.p_WCas[0].tolist(),
                'p_WCb': row.p_WCbs[0].tolist(),
                'nhat_BA_W': row.nhat_BA_Ws[0].tolist(),
                'reported': moment.pairs.find(pair) is not None,
            }
        return plain, row

    def explanation(self, pair: tuple[int, int]) -> str:
        """Return why queries leave a pair out; empty if they report it."""
        now = time.monotonic()
        if pair != self._pair:
            self._pair, self._filter, self._due = pair, _ASKING, 0.0
        if now >= self._due:
            self._due = now + _PERIOD
            self._asking.submit(self._explain, pair)
        return self._filter

    def _explain(self, pair: tuple[int, int]) -> None:
        try:
            reasons = self._scene.explain(pair)
            said = f'filtered by {", ".join(reasons)}' if reasons else ''
        except (GeometryError, RuntimeError) as error:
            said = str(error)
        if pair == self._pair and said != self._filter:
            self._filter = said
            self._touch()


def _posed(poses: Mapping[int, RigidTransform | None]) -> dict[int, RigidTransform]:
    return {value: X for value, X in poses.items() if X is not None}


def _rows(body: ShownBody | None, X_WG: RigidTransform | None) -> list[tuple[str, str]]:
    rows = [('shape', 'not known')] if body is None else body.rows()
    if X_WG is None:
        return [*rows, ('pose', 'none')]
    x, y, z = X_WG.translation().tolist()
    angles = RollPitchYaw(X_WG.rotation()).vector().tolist()
    degrees = ' '.join(f'{round(math.degrees(angle), 2) + 0.0:.2f}°' for angle in angles)
    return [
        *rows,
        ('position', f'{x:.4f} {y:.4f} {z:.4f} m'),
        ('roll pitch yaw', degrees),
    ]
