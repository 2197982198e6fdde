"""The pairs of half spaces of a packed scene, state after state, for one thread."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.pairs.answer_rows import PairBatch
from drake_geom_ros.geometry._proximity.world.joint_poses import JointChain, pose_links
from drake_geom_ros.geometry._proximity.world.pose_rows import POSE_WIDTH, read_poses
from drake_geom_ros.geometry._proximity.world.world import Named
from drake_geom_ros.geometry.errors import PoseError
from drake_geom_ros.geometry.queries.half_space_pairs import HalfSpaceGaps, gaps_of
from drake_geom_ros.geometry.queries.half_space_rows import rows_of_gaps
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.padding import Paddings
from drake_geom_ros.math.array_types import Floats

Booleans = NDArray[np.bool_]


class HalfSpaceStates:
    """Gaps of the pairs of half spaces of a packed scene; ids are places in the scene.

    ``chain`` poses the scene's moved frames where states are joint values. It is done in Python,
    since hardly any scene has such a pair; ``of`` returns None for a scene without one.
    """

    def __init__(self, scene: PackedScene, chain: JointChain | None = None) -> None:
        self._world, self._pairs = scene.world(), scene.half_spaces.copy()
        self._named = Named(self._world.frames.ids[scene.moved], scene.moved.copy())
        self._paddings = Paddings(scene.paddings, scene.meshes) if scene.paddings.any() else None
        # (k,) True for pairs whose bodies may move relative to each other
        carriers = scene.carriers()[scene.half_spaces]
        self.moves: Booleans = carriers[:, 0] != carriers[:, 1]
        self._chain = None if chain is None else chain._replace(X_WLs=chain.X_WLs.copy())

    @classmethod
    def of(cls, scene: PackedScene, chain: JointChain | None = None) -> HalfSpaceStates | None:
        """Return the states of a scene, None if it has no pair of half spaces."""
        return cls(scene, chain) if len(scene.half_spaces) else None

    def stand(self, R_PFs: Floats, p_PFs: Floats) -> None:
        """Set the poses (nf, 3, 3) and (nf, 3) [m] of all frames, by place."""
        self._world.set_poses(np.arange(1, len(p_PFs)), R_PFs[1:], p_PFs[1:])

    def drive_by(self, chain: JointChain) -> None:
        """Take the numbers of a chain with the same links and columns as the one at first."""
        assert self._chain is not None
        self._chain = chain._replace(X_WLs=chain.X_WLs.copy())

    def at_rows(self, X_PFs: Floats) -> HalfSpaceGaps:
        """Return the gaps at poses (n, POSE_WIDTH) of the moved frames."""
        self._world.pose(self._named, X_PFs)
        self._world.update()
        return gaps_of(self._world, self._pairs, self._paddings)

    def at(self, poses: Floats) -> HalfSpaceGaps:
        """Return the gaps in a state (n, 7); raises PoseError for an invalid pose."""
        X_PFs = np.empty((len(poses), POSE_WIDTH))
        if read_poses(poses, X_PFs) < len(poses):
            raise PoseError('a state of half spaces has a pose that is none')
        return self.at_rows(X_PFs)

    def answers_at(self, poses: Floats) -> PairBatch:
        """Return the answers about the pairs in a state (n, 7); raises as ``at``."""
        return rows_of_gaps(self.at(poses), self._world, self._paddings)

    def at_joints(self, values: Floats) -> HalfSpaceGaps:
        """Return the gaps at joint values (c,); raises PoseError as ``at``."""
        assert self._chain is not None
        poses = np.empty((1, len(self._chain.links), 7))
        pose_links(np.ascontiguousarray(values)[None], tuple(self._chain), 0, poses)
        return self.at(poses[0])


class SpanOfHalfSpaces(NamedTuple):
    """Result for the pairs of half spaces over a motion, with the worst pair by its places.

    A pair is reported unless the ``outcome`` is 'clear', with its distance at the start.
    ``lower_bound`` [m] is the smallest proved one, ``ignored`` the number of omitted pairs.
    """

    outcome: str
    lower_bound: float
    ignored: int
    a: int = -1
    b: int = -1
    distance: float = math.inf  # [m]
    error_bound: float = 0.0  # [m]


def span_of(
    start: HalfSpaceGaps,
    end: HalfSpaceGaps | None,
    moves: Booleans,
    left_out: Booleans,
    min_distance: float,
) -> SpanOfHalfSpaces:
    """Return the result for pairs (k,) over a motion between two states.

    Pairs whose bodies do not move relative to each other keep their gap at the ``start``. Where no
    frame turns, opposed planes stay opposed, and their gap is smallest at the start or the
    ``end``. Where a frame turns, ``end`` is None, and nothing is proved for pairs in ``moves``:
    they cross as soon as they are not exactly opposed, which no bound on speeds excludes.
    """
    if end is None:
        lower = np.where(moves, -math.inf, start.lower)
    else:
        lower = np.minimum(start.lower, end.lower)
    lower[left_out] = math.inf
    least, ignored = float(lower.min(initial=math.inf)), int(np.count_nonzero(left_out))
    if least > min_distance:
        return SpanOfHalfSpaces('clear', least, ignored)
    upper = np.where(left_out, math.inf, start.distance + start.error_bound)
    touches = float(upper.min()) <= min_distance
    worst = int(np.argmin(upper if touches else lower))
    a, b = start.ids[worst].tolist()
    return SpanOfHalfSpaces(
        'contact' if touches else 'unknown',
        float(start.lower[worst]),
        ignored,
        a,
        b,
        float(start.distance[worst]),
        float(start.error_bound[worst]),
    )
