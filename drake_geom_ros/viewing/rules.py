"""Proximity rules for display: their states and nearest pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drake_geom_ros.proximity_rules import Level, Measured, WatchedPairs
from drake_geom_ros.viewing.shown_pairs import ReportedPairs

# Colours of levels, 0 to 255, for texts and for lines between the pairs of entered rules.
COLOURS = {
    Level.WARN: (230, 190, 0),
    Level.SLOW: (255, 120, 0),
    Level.STOP: (255, 0, 0),
    Level.STOPPABLE: (200, 0, 160),
}


@dataclass(frozen=True)
class ShownRule:
    """State of a rule; ``pair`` are the id values of its nearest shown pair, if any."""

    name: str
    level: Level
    is_entered: bool
    said: str  # why it is entered, or can never be
    pair: tuple[int, int] | None = None

    def in_words(self) -> str:
        """Return the state as a text."""
        stands = f'entered, {self.said}' if self.is_entered else self.said or 'not entered'
        return f'{self.name}: {self.level.name.lower()}, {stands}'


def nearest_by_rule(watched: WatchedPairs, pairs: ReportedPairs) -> dict[int, tuple[int, int]]:
    """Return the nearest shown pair (id values) by the number of a rule."""
    # The shown scene may be older than the pairs, and lack geometries of theirs.
    present = pairs.rows(np.flatnonzero(np.isin(pairs.ids, watched.ids).all(axis=1)))
    measured = Measured(
        id_A=present.ids[:, 0],
        id_B=present.ids[:, 1],
        distance=present.distance,
        error_bound=present.error_bound,
        p_WCa=present.p_WCas,
        p_WCb=present.p_WCbs,
    )
    nearest = watched.nearest(measured).lowest_pair.tolist()
    ids = list(map(tuple, present.ids.tolist()))
    return {rule: ids[row] for rule, row in enumerate(nearest) if row >= 0}


def rows_of_level(rules: Sequence[ShownRule], pairs: ReportedPairs, level: Level) -> list[int]:
    """Return the rows of the nearest pairs of entered rules of a level."""
    entered = [rule.pair for rule in rules if rule.is_entered and rule.level == level]
    rows = [pairs.find(pair) for pair in dict.fromkeys(entered) if pair is not None]
    return [row for row in rows if row is not None]
