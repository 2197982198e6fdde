"""The laws that answers must keep, as defect over what is allowed: above 1 a law is broken.

No truth is asked: an independent plane proves a certificate false from below, and answers must
agree with each other. Where no plane attains the distance either the search was too coarse or
the certificate is false from above: ``suspects`` says where, and ``asking`` asks the truth there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bench.searches.hunting import planes
from bench.searches.hunting.scene import Distances, Replies
from drake_geom_ros.cross_check.bodies import Pair
from drake_geom_ros.cross_check.surfaces import off_surfaces
from drake_geom_ros.math.array_types import Floats
from truth.judging import laws
from truth.tolerances import (
    AS_TOUCHING,
    COARSE_NORMALS,
    POSITIONS,
    ROUNDING,
    TURNED,
    UNIT,
)

TINY = math.ulp(0.0)

LAWS = (
    *('certificate', 'promise', 'surface', 'normal', 'identity', 'unit', 'finite', 'levels'),
    *('history', 'hint', 'contact', 'point', 'order', 'motion', 'scale', 'unique'),
)

Ratios = dict[str, Floats]  # of each law, for n pairs


class Judged:
    """Some pairs as posed, the answers about them, and how they keep the laws."""

    def __init__(
        self,
        pairs: Sequence[Pair],
        origins: Floats,
        replies: Replies,
        nhats: Floats | None = None,
    ) -> None:
        """``origins`` (n, 3) [m] is where A's are, ``nhats`` (n, 3) the normals, if known."""
        self.pairs, self.replies = pairs, replies
        self.extent = np.array([pair.extent for pair in pairs])
        self.away = self.extent + np.abs(origins).max(axis=1).astype(float)
        self.packed = planes.packed(pairs)
        self._at_origin = [
            Pair(*(one.placed(np.eye(3), np.zeros(3)) for one in (pair.a, pair.b)))
            for pair in pairs
        ]
        if nhats is None:
            normals = np.stack(
                [replies.levels['exact'].nhat_BA_W, replies.fresh.nhat_BA_W], axis=1
            )
            normals = np.where(np.isfinite(normals), normals, 0.0)
            self.gap, n = planes.widest(self.packed, normals)
            self.nhats = -n
        else:
            self.gap, self.nhats = planes.gaps(self.packed, nhats), nhats
        self.ratios = self._ratios()

    def _answers(self) -> list[Distances]:
        return [*self.replies.levels.values(), self.replies.fresh]

    def suspects(self) -> Floats:
        """Return how far (n,) the distances, less all that is allowed, exceed every plane found.

        Relative to what is allowed; above 1 a certificate may be false from above.
        """
        exact, noise = self.replies.levels['exact'], ROUNDING * self.extent
        return (exact.distance - self.gap) / (exact.error_bound + noise)

    def _ratios(self) -> Ratios:
        levels = self.replies.levels
        exact, fresh = levels['exact'], self.replies.fresh
        touching = AS_TOUCHING * self.extent
        computed = [x for level, x in levels.items() if level != 'bound'] + [fresh]
        ratios = {
            'finite': _most(np.where(_finite(x), 0.0, np.inf) for x in self._answers()),
            'certificate': _most(map(self._beyond, self._answers())),
            'promise': _most(x.error_bound / x.promised for x in computed),
            'identity': _most(map(self._identity, computed)),
            'unit': _most(laws.off_unit(x.nhat_BA_W) / UNIT for x in computed),
            'surface': _most(map(self._off_surfaces, (exact, fresh))),
            'normal': _most(map(self._not_attained, (exact, fresh))),
            'levels': _most(agreement(exact, x, touching) for x in levels.values()),
            'history': agreement(exact, fresh),
            'unique': turned(exact, fresh),
            'contact': _most([*map(self._contacts, levels), self._collisions()]),
        }
        return {law: np.where(np.isnan(ratio), np.inf, ratio) for law, ratio in ratios.items()}

    def of_hints(self, hinted: Distances) -> Ratios:
        """Return how answers that started from hints keep the laws."""
        exact = self.replies.levels['exact']
        worst = [agreement(exact, hinted), self._beyond(hinted),
                 hinted.error_bound / hinted.promised]  # fmt: skip
        return {'hint': np.max(worst, axis=0)}

    def _beyond(self, x: Distances) -> Floats:
        """Return by how much of its bound a plane is wider than an answer."""
        noise = ROUNDING * self.extent
        return (self.gap - x.distance) / (x.error_bound + noise)

    def _identity(self, x: Distances) -> Floats:
        off = laws.off_span(x.distance, x.nhat_BA_W, x.p_WCa, x.p_WCb)
        return off / (POSITIONS * self.away)

    def _off_surfaces(self, x: Distances) -> Floats:
        seen = zip(self._at_origin, x.p_ACa, x.p_BCb, strict=True)
        off = np.array([off_surfaces(*each) for each in seen])
        return off / (x.error_bound + POSITIONS * self.extent)

    def _not_attained(self, x: Distances) -> Floats:
        lacking = x.distance - planes.gaps(self.packed, x.nhat_BA_W)
        return lacking / (x.error_bound + (POSITIONS + COARSE_NORMALS) * self.extent)

    def _contacts(self, level: str) -> Floats:
        """Return whether penetrations and distances of a level tell of the same contacts."""
        x, depths = self.replies.levels[level], self.replies.depths[level]
        noise, reported = AS_TOUCHING * self.extent, ~np.isnan(depths.depth)
        # What overlaps by more than the level may be off is reported; where bounds alone answer,
        # whatever overlaps. At their level what is known of a pair from another one counts too.
        exact, coarsest = self.replies.levels['exact'], self.replies.levels['fast']
        off = coarsest.promised if level == 'bound' else x.promised
        allowed = exact.error_bound + noise + np.where(x.by_bounds, 0.0, off)
        missed = np.where(~reported & (exact.distance < -allowed), np.inf, 0.0)
        # The true depth is at most that of any plane; none is reported of what is surely apart.
        proven = (self.gap + depths.depth) / (depths.error_bound + noise)
        apart = np.abs(x.distance + depths.depth) / (x.error_bound + depths.error_bound + noise)
        if level == 'bound':
            apart = np.zeros_like(apart)  # two intervals that hold the truth, not one
        return np.fmax(missed, np.fmax(proven, apart))

    def _collisions(self) -> Floats:
        """Return whether HasCollisions and the candidates miss a contact, or make one up."""
        exact, depths = self.replies.levels['exact'], self.replies.depths['exact']
        broken = ~np.isnan(depths.depth) & ~self.replies.candidates
        allowed = exact.error_bound + exact.promised
        if self.replies.collides:
            broken |= (exact.distance > allowed).all()
        else:
            broken |= exact.distance < -allowed
        return np.where(broken, np.inf, 0.0)

    def of_points(self, offsets: Floats, answers: tuple[Floats, Floats]) -> Ratios:
        """Return how answers about points, ``offsets`` (n, 3) from A, keep what planes prove."""
        distance, bound = answers
        gap, _ = planes.widest(self._with_points(offsets), -self.nhats[:, None])
        return {'point': (gap - distance) / (bound + ROUNDING * self.extent)}

    def _with_points(self, offsets: Floats) -> planes.Packed:
        """Return the pairs, points instead of B."""
        vertices, counts, radii, flats = (x.copy() for x in self.packed[:4])
        for x in (vertices, radii, flats):
            x[:, 1] = 0.0
        counts[:, 1] = 1
        of_a = np.where(self.packed.half_spaces == 1, 1, 0)
        return planes.Packed(vertices, counts, radii, flats, self.packed.Rs, offsets, of_a)


def agreement(x: Distances, y: Distances, slack: Floats | float = 0.0, s: float = 1.0) -> Floats:
    """Return how far y, of lengths s times as large, is from x, over the sum of their bounds."""
    return np.abs(y.distance - s * x.distance) / (s * x.error_bound + y.error_bound + slack)


def turned(x: Distances, y: Distances, sign: float = 1.0) -> Floats:
    """Return how far two normals, both said to be unique, are apart."""
    cosine = sign * np.einsum('ij,ij->i', x.nhat_BA_W, y.nhat_BA_W)
    return np.where(x.unique & y.unique, (1.0 - cosine) / TURNED, 0.0)


def _finite(x: Distances) -> Floats:
    columns = (x.distance, x.error_bound, x.nhat_BA_W, x.p_WCa, x.p_WCb, x.p_ACa, x.p_BCb)
    return np.all([np.isfinite(c.reshape(len(c), -1)).all(axis=1) for c in columns], axis=0)


def _most(ratios) -> Floats:
    return np.max(list(ratios), axis=0)
