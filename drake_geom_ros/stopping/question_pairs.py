"""Pairs that a question about stops is about, and the columns that move them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry.queries.joint_motions import JointMotions
from drake_geom_ros.math.array_types import Flags, Floats, Indices
from drake_geom_ros.stopping.stop import StoppingQuestion


class QuestionPairs(NamedTuple):
    """Pairs that columns of a question move, of a scene with geometries (n,) and columns (c,)."""

    rows: Indices  # (k,) of the scene's pairs
    relative: Flags  # (k, c) columns that move the bodies of a pair relative to each other
    shared: Flags  # (k,) pairs that columns of other questions move, too
    slow: Flags  # (k,) pairs whose distances take longest: of sensed maps and solids
    own: Flags  # (c,) columns that brake
    others: Flags  # (c,) columns of other questions that move any of the pairs
    loose_a: Flags  # (c,) columns that nobody brakes, of set_a
    loose_b: Flags  # (c,) and of the rest
    in_a: Flags  # (n,)
    in_b: Flags
    moving_a: Flags  # (n,) geometries of set_a that the own columns move
    moved_by: Flags  # (n, c)
    speeds: Floats  # (n,) [m/s] at which geometries may move by themselves
    has_half_spaces: bool  # pairs of two half spaces are among them

    @classmethod
    def of(
        cls, question: StoppingQuestion, own: Flags, by_any: Flags, motions: JointMotions
    ) -> QuestionPairs:
        """Return the pairs of a question whose ``own`` columns brake; ``by_any``: of all."""
        ids, moved_by, loose = motions.ids, motions.moved_by, ~by_any
        in_a: Flags = np.isin(ids, np.fromiter(question.set_a, np.int64))
        in_b: Flags = ~in_a
        if question.set_b is not None:
            in_b = np.isin(ids, np.fromiter(question.set_b, np.int64))
        loose_a: Flags = moved_by[in_a].any(axis=0) & loose
        can_move = motions.can_move | moved_by[:, loose & ~loose_a].any(axis=1)
        rows = np.flatnonzero(between(motions.pairs, in_a, in_b))
        relative = motions.relative(motions.pairs[rows])
        matters = relative[:, own].any(axis=1)
        rows, relative = rows[matters], relative[matters]
        pairs = motions.pairs[rows]
        moves_pairs = relative.any(axis=0)
        others: Flags = by_any & ~own & moves_pairs
        halves = motions.half_spaces[between(motions.half_spaces, in_a, in_b)]
        return cls(
            rows=rows,
            relative=relative,
            shared=np.asarray(relative[:, others].any(axis=1)),
            slow=np.asarray(motions.is_slow[pairs].any(axis=1)),
            own=own,
            others=others,
            loose_a=loose_a,
            loose_b=moved_by[np.unique(pairs)].any(axis=0) & loose,
            in_a=in_a,
            in_b=in_b,
            moving_a=in_a & moved_by[:, own].any(axis=1),
            moved_by=moved_by,
            speeds=np.where(can_move, question.max_speed, 0.0),
            has_half_spaces=bool(motions.relative(halves)[:, own].any()),
        )

    @property
    def moves_pairs(self) -> Flags:
        """The columns (c,) that move any of the pairs."""
        return np.asarray(self.relative.any(axis=0))


def between(pairs: Indices, in_a: Flags, in_b: Flags) -> Flags:
    """Return which of pairs (k, 2) have one body in each of two sets."""
    a, b = pairs[:, 0], pairs[:, 1]
    return np.asarray((in_a[a] & in_b[b]) | (in_b[a] & in_a[b]))
