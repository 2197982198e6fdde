"""The same pairs asked about in five ways, and what the laws say of all of these together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.searches.hunting import judge
from bench.searches.hunting.chains import ChainedScene
from bench.searches.hunting.judge import Judged, Ratios
from bench.searches.hunting.scene import PairsScene
from drake_geom_ros.cross_check.bodies import Pair
from drake_geom_ros.math.array_types import Floats
from truth.bodies.random_bodies import random_rotation
from truth.references import convex
from truth.tolerances import ROUNDING, SEARCH

GIVEN, CHAIN = 'given', 'chain'
POWERS = (-30, 14)  # of two, of other scales
AWAY = 3.0  # extents that a common motion leads
CHAINED = 0.25  # part of the times that chains are asked about too: to pose them takes long
EXACT = 1  # suspects each time the scenes are asked that are told by 40 digits


class Scenes:
    """Scenes of the shapes of n pairs: as given, in the other order, moved, scaled, on chains."""

    def __init__(
        self, pairs: Sequence[Pair], rng: np.random.Generator, chains: bool = True
    ) -> None:
        self._rng = rng
        self._power = float(2.0 ** rng.integers(*POWERS))
        self._scenes = {
            GIVEN: PairsScene(pairs),
            'order': PairsScene([pair.swapped() for pair in pairs]),
            'motion': PairsScene(pairs),
            'scale': PairsScene([pair.scaled(self._power) for pair in pairs]),
        }
        if chains:
            self._scenes[CHAIN] = ChainedScene(pairs, rng)

    def ask(self, pairs: Sequence[Pair], hints: Floats) -> dict[str, Judged]:
        """Return what is judged of pairs of the same shapes in new poses, by the scenes' names.

        ``hints`` (n, 3) are normals to start from; the laws between scenes are under GIVEN.
        """
        R, direction = random_rotation(self._rng), AWAY * self._rng.normal(size=3)
        posed = {
            'order': [pair.swapped() for pair in pairs],
            'motion': [pair.moved(R, pair.extent * direction) for pair in pairs],
            'scale': [pair.scaled(self._power) for pair in pairs],
        }
        given = self._judged(GIVEN, pairs)
        given.ratios.update(given.of_hints(self._scenes[GIVEN].hinted(hints)))
        # Where the widest gap is holds for the same pair seen from elsewhere.
        known = {'order': -given.nhats, 'motion': given.nhats @ R.T, 'scale': given.nhats}
        judged = {name: self._judged(name, posed[name], known[name]) for name in posed}
        judged = {GIVEN: given, **judged}
        if CHAIN in self._scenes and self._rng.random() < CHAINED:
            judged[CHAIN] = self._judged(CHAIN, pairs)
        for name in [name for name in (GIVEN, CHAIN) if name in judged]:
            scene = self._scenes[name]
            points = np.array([pair.b.p for pair in pairs])
            offsets = (points - scene.origins).astype(float)
            judged[name].ratios.update(judged[name].of_points(offsets, scene.to_points(points)))
        _tell_suspects(given)
        judged[GIVEN].ratios.update(self._between(judged))
        return judged

    def _judged(self, name: str, pairs: Sequence[Pair], nhats: Floats | None = None) -> Judged:
        scene = self._scenes[name]
        pairs = scene.place(pairs)
        return Judged(pairs, scene.origins, scene.replies(self._rng), nhats)

    def _between(self, judged: dict[str, Judged]) -> Ratios:
        """Return how the answers of the scenes agree with each other."""
        given, *others = (
            judged[name].replies.levels['exact'] for name in (GIVEN, 'order', 'motion', 'scale')
        )
        order, motion, scale = others
        rounding = ROUNDING * judged['motion'].away
        return {
            'order': judge.agreement(given, order, judge.TINY),
            'unique': np.maximum(judged[GIVEN].ratios['unique'], judge.turned(given, order, -1.0)),
            'motion': judge.agreement(given, motion, rounding),
            'scale': judge.agreement(given, scale, judge.TINY, self._power),
        }


def merged(judged: dict[str, Judged]) -> Ratios:
    """Return the worst of all scenes, of each law, for n pairs."""
    ratios = [each.ratios for each in judged.values()]
    return {
        law: np.max([some[law] for some in ratios if law in some], axis=0)
        for law in judged[GIVEN].ratios
    }


def broken(pair: Pair, seed: int = 0) -> list[str]:
    """Return the laws that answers about a pair break."""
    scenes = Scenes([pair], np.random.default_rng(seed))
    found = merged(scenes.ask([pair], np.zeros((1, 3))))
    return [law for law, ratio in found.items() if ratio[0] > 1.0]


def _tell_suspects(judged: Judged) -> None:
    """Let 40 digits tell whether certificates are false where no plane attains a distance."""
    suspicion = judged.suspects()
    for k in np.argsort(-suspicion)[:EXACT]:
        if suspicion[k] > 1.0:
            judged.ratios['certificate'][k] = max(
                judged.ratios['certificate'][k], _error(judged, k)
            )


def _error(judged: Judged, k: int) -> float:
    """Return by how much of what is allowed a distance exceeds the truth."""
    pair, row = judged.pairs[k], judged.replies.levels['exact']
    allowed = row.error_bound[k] + ROUNDING * judged.extent[k]
    # A sharper plane beside the best one may be enough.
    known = convex.of_any_size(pair, -judged.nhats[k])
    near = (row.distance[k] - known) / allowed
    if near <= 1.0:
        return float(near)
    allowed += SEARCH * judged.extent[k]
    # Every plane proves a distance, so the larger one is nearer to the truth: of needles that are
    # 1e11 times as long as they are thick, the search finds a worse plane than the given one.
    return float((row.distance[k] - max(known, convex.of_any_size(pair))) / allowed)
