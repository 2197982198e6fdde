"""Proximity rules as they are shown: how each stands, and the pair that it is nearest by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drake_geom_ros.proximity_rules import Level, Measured, WatchedPairs
from drake_geom_ros.viewing.pairs import Pairs

# Of levels, 0 to 255: of the lines between the pairs of rules that are entered, and of words.
COLOURS = {Level.WARN: (230, 190, 0), Level.SLOW: (255, 120, 0), Level.STOP: (255, 0, 0)}


@dataclass(frozen=True)
class ShownRule:
    """A rule; ``pair`` are the id values of the pair that keeps it entered, if any is shown."""

    name: str
    level: Level
    is_entered: bool
    said: str  # why it is entered, or can never be
    pair: tuple[int, int] | None = None

    def in_words(self) -> str:
        """Return how it stands."""
        stands = f'entered, {self.said}' if self.is_entered else self.said or 'not entered'
        return f'{self.name}: {self.level.name.lower()}, {stands}'


def nearest_by_rule(watched: WatchedPairs, pairs: Pairs) -> dict[int, tuple[int, int]]:
    """Return by the number of a rule the nearest pair (id values) of those that are shown."""
    # The scene that is shown may be older than the pairs.
    known = pairs.rows(np.flatnonzero(np.isin(pairs.ids, watched.ids).all(axis=1)))
    measured = Measured(
        id_A=known.ids[:, 0],
        id_B=known.ids[:, 1],
        distance=known.distance,
        error_bound=known.error_bound,
        p_WCa=known.p_WCas,
        p_WCb=known.p_WCbs,
    )
    nearest = watched.nearest(measured).lowest_pair.tolist()
    ids = list(map(tuple, known.ids.tolist()))
    return {rule: ids[row] for rule, row in enumerate(nearest) if row >= 0}


def rows_of_level(rules: Sequence[ShownRule], pairs: Pairs, level: Level) -> list[int]:
    """Return the rows of the pairs by which rules of a level are entered."""
    entered = [rule.pair for rule in rules if rule.is_entered and rule.level == level]
    rows = [pairs.find(pair) for pair in dict.fromkeys(entered) if pair is not None]
    return [row for row in rows if row is not None]
