"""The search: pairs evolve, each towards breaking one of the laws."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bench.searches.hunting import starts
from bench.searches.hunting.asking import CHAIN, GIVEN, Scenes, merged
from bench.searches.hunting.judge import LAWS, Judged
from bench.searches.hunting.mutation import Last, mutated_pose, mutated_size
from drake_geom_ros.cross_check.bodies import Pair
from drake_geom_ros.math.array_types import Floats
from truth.tolerances import ROUNDED_SKEW

SLOTS = 48  # pairs that evolve beside each other
STEPS = 10  # poses that a scene's pairs are tried in, before sizes change
NEW = 0.4  # part of the slots that start afresh with each scene
ELITE = 0.3  # part of the others that go on from the worst of their law
# Of poses: plain ones, with a rotation off orthogonal by more, and composed along chains.
PLAIN, SKEWED = 'plain', 'skewed'
WAYS = PLAIN, SKEWED, CHAIN


class Key(NamedTuple):
    """What a find is about: a law, the kinds of the pair, and one of WAYS."""

    law: str
    kinds: str
    way: str


class Find(NamedTuple):
    """The worst that was seen of it; ``scene`` is where."""

    ratio: float
    pair: Pair
    scene: str


class Hunt:
    """A search that goes on by generations; deterministic for a seed.

    ``broken`` counts the answers that broke a law.
    """

    def __init__(self, seed: int, slots: int = SLOTS) -> None:
        self.worst: dict[Key, Find] = {}
        self.broken: dict[Key, int] = {}
        self.judged = 0
        self._rng = np.random.default_rng(seed)
        self._aims = [LAWS[k % len(LAWS)] for k in range(slots)]
        self._pairs = [self._fresh() for _ in range(slots)]

    def generation(self) -> None:
        """Let the pairs evolve in scenes of their shapes, then change the shapes."""
        rng, count = self._rng, len(self._pairs)
        scenes = Scenes(self._pairs, rng)
        trials, hints, best = self._pairs, np.zeros((count, 3)), np.full(count, -np.inf)
        for _ in range(STEPS):
            judged = scenes.ask(trials, hints)
            self.judged += count * len(judged)
            for scene, each in judged.items():
                self._keep(scene, each)
            ratios = merged(judged)
            scores = np.array([ratios[law][k] for k, law in enumerate(self._aims)])
            for k in np.flatnonzero(scores >= best):
                self._pairs[k], best[k] = trials[k], scores[k]
            row = judged[GIVEN].replies.levels['exact']
            hints = self._hints(row.nhat_BA_W, hints)
            last = map(Last, row.distance.tolist(), row.nhat_BA_W)
            trials = [mutated_pose(rng, *each) for each in zip(self._pairs, last, strict=True)]
        self._pairs = [self._next(*each) for each in zip(self._pairs, self._aims, strict=True)]

    def _fresh(self) -> Pair:
        while not starts.valid(pair := starts.random_pair(self._rng)):
            pass
        return pair

    def _next(self, pair: Pair, aim: str) -> Pair:
        """Return a new pair, or a child of the old one or of the worst of the law aimed at."""
        if self._rng.random() < NEW:
            return self._fresh()
        worst = [find.pair for key, find in self.worst.items() if key.law == aim]
        if worst and self._rng.random() < ELITE:
            pair = worst[self._rng.integers(len(worst))]
        child = mutated_size(self._rng, pair)
        return child if starts.valid(child) else pair

    def _hints(self, normals: Floats, hints: Floats) -> Floats:
        """Return hints of earlier answers, of other pairs, against the normal or of no sense."""
        n = len(normals)
        kinds = [hints, normals[self._rng.permutation(n)], -normals,
                 self._rng.normal(size=(n, 3)), np.zeros((n, 3))]  # fmt: skip
        chosen: Floats = np.array(kinds)[self._rng.integers(len(kinds), size=n), np.arange(n)]
        return chosen

    def _keep(self, scene: str, judged: Judged) -> None:
        """Remember the worst pairs of each law and kinds."""
        for k, pair in enumerate(judged.pairs):
            kinds = '-'.join(sorted((pair.a.kind, pair.b.kind)))
            way = CHAIN if scene == CHAIN else _way(pair)
            for law, ratios in judged.ratios.items():
                ratio, key = float(ratios[k]), Key(law, kinds, way)
                if ratio > 1.0:
                    self.broken[key] = self.broken.get(key, 0) + 1
                if key not in self.worst or ratio > self.worst[key].ratio:
                    self.worst[key] = Find(ratio, pair, scene)


def _way(pair: Pair) -> str:
    return SKEWED if max(pair.a.skew, pair.b.skew) > ROUNDED_SKEW else PLAIN
