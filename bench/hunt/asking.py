"""The same pairs asked about in five ways, and what the laws say of all of these together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.hard_cases.cases import Case, Floats
from bench.hunt import exact, laws
from bench.hunt.chains import ChainedScene
from bench.hunt.laws import Judged, Ratios
from bench.hunt.scene import PairsScene
from drake_geom_ros.accuracy.solids import random_rotation

GIVEN, CHAIN = 'given', 'chain'
POWERS = (-30, 14)  # of two, of other scales
AWAY = 3.0  # extents that a common motion leads
CHAINED = 0.25  # part of the times that chains are asked about too: to pose them takes long
EXACT = 1  # suspects each time the scenes are asked that are told by 40 digits


class Scenes:
    """Scenes of the shapes of n pairs: as given, in the other order, moved, scaled, on chains."""

    def __init__(
        self, pairs: Sequence[Case], rng: np.random.Generator, chains: bool = True
    ) -> None:
        self._rng = rng
        self._power = float(2.0 ** rng.integers(*POWERS))
        self._scenes = {
            GIVEN: PairsScene(pairs),
            'order': PairsScene([case.swapped() for case in pairs]),
            'motion': PairsScene(pairs),
            'scale': PairsScene([case.scaled(self._power) for case in pairs]),
        }
        if chains:
            self._scenes[CHAIN] = ChainedScene(pairs, rng)

    def ask(self, pairs: Sequence[Case], hints: Floats) -> dict[str, Judged]:
        """Return what is judged of pairs of the same shapes in new poses, by the scenes' names.

        ``hints`` (n, 3) are normals to start from; the laws between scenes are under GIVEN.
        """
        R, direction = random_rotation(self._rng), AWAY * self._rng.normal(size=3)
        posed = {
            'order': [case.swapped() for case in pairs],
            'motion': [case.moved(R, case.extent * direction) for case in pairs],
            'scale': [case.scaled(self._power) for case in pairs],
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
            points = np.array([case.b.p for case in pairs])
            offsets = (points - scene.origins).astype(float)
            judged[name].ratios.update(judged[name].of_points(offsets, scene.to_points(points)))
        _tell_suspects(given)
        judged[GIVEN].ratios.update(self._between(judged))
        return judged

    def _judged(self, name: str, pairs: Sequence[Case], nhats: Floats | None = None) -> Judged:
        scene = self._scenes[name]
        cases = scene.pose(pairs)
        return Judged(cases, scene.origins, scene.replies(self._rng), nhats)

    def _between(self, judged: dict[str, Judged]) -> Ratios:
        """Return how the answers of the scenes agree with each other."""
        given, *others = (
            judged[name].replies.levels['exact'] for name in (GIVEN, 'order', 'motion', 'scale')
        )
        order, motion, scale = others
        rounding = laws.PLANE_ROUNDING * judged['motion'].away
        return {
            'order': laws.agreement(given, order, laws.TINY),
            'unique': np.maximum(judged[GIVEN].ratios['unique'], laws.turned(given, order, -1.0)),
            'motion': laws.agreement(given, motion, rounding),
            'scale': laws.agreement(given, scale, laws.TINY, self._power),
        }


def merged(judged: dict[str, Judged]) -> Ratios:
    """Return the worst of all scenes, of each law, for n pairs."""
    ratios = [each.ratios for each in judged.values()]
    return {
        law: np.max([some[law] for some in ratios if law in some], axis=0)
        for law in judged[GIVEN].ratios
    }


def broken(case: Case, seed: int = 0) -> list[str]:
    """Return the laws that answers about a pair break."""
    scenes = Scenes([case], np.random.default_rng(seed))
    found = merged(scenes.ask([case], np.zeros((1, 3))))
    return [law for law, ratio in found.items() if ratio[0] > 1.0]


def _tell_suspects(judged: Judged) -> None:
    """Let 40 digits tell whether certificates are false where no plane attains a distance."""
    suspicion = judged.suspects()
    for k in np.argsort(-suspicion)[:EXACT]:
        if suspicion[k] > 1.0:
            ratio = exact.error(judged, int(k))
            judged.ratios['certificate'][k] = max(judged.ratios['certificate'][k], ratio)
