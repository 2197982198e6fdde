"""Motions of joints in a live scene: prepared once, and asked again as other bodies move."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kinds import OCCUPIED_CELLS, POINT_CLOUD, SOLID
from drake_geom_ros.geometry.queries.accuracy import AccuracyLike
from drake_geom_ros.geometry.queries.context import SceneGraphContext, state_of
from drake_geom_ros.geometry.queries.joint_trees import JointChain
from drake_geom_ros.geometry.queries.motion_queries import MotionQueries
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.state_queries import accuracy_in
from drake_geom_ros.geometry.queries.stop_queries import StopQueries
from drake_geom_ros.math.array_types import Floats, Indices

Flags = NDArray[np.bool_]
_MAPS = (OCCUPIED_CELLS, POINT_CLOUD)


class JointMotions:
    """The pairs of one version of a scene, and which joint values move their bodies.

    ``ids`` (n,) are the geometries, ascending, and identify them by place. ``pairs`` (k, 2) are
    those that may be reported, ``half_spaces`` (m, 2) those of two half spaces, both by place.
    ``moved_by`` (n, c) flags the columns of joint values that move a geometry in the world, and
    ``can_move`` (n,) the geometries that something else may move, too: sensed maps, and whatever
    hangs on a frame that is not a link, nor welded to the world, nor one of those at rest.
    ``is_slow`` (n,) flags those whose distances take longest: sensed maps and solids.
    """

    def __init__(
        self,
        context: SceneGraphContext,
        chain: JointChain,
        frame_ids: Indices,
        columns: int,
        accuracy: AccuracyLike = '',
        resting: Collection[int] = (),
    ) -> None:
        """``frame_ids`` (f,) are the frames of the chain's ``links``; ``resting`` ones stand.

        Raises PoseError for frames that are not in the scene.
        """
        self._context = context
        self._accuracy = accuracy_in(context, accuracy)
        self._mark = _mark(context)
        self._frame_ids = state_of(context).up_to_date_world().frames.ids
        self._chain = chain
        self._leads_several = _leads_several(chain, columns)
        self._scene, self.ids = PackedScene.of(
            context, frame_ids, about_points=False, with_waiting=True
        )
        self.pairs, self.half_spaces = self._scene.pairs, self._scene.half_spaces
        of_frames = _columns_of_frames(self._scene, chain, columns)
        self.moved_by: Flags = of_frames[self._scene.frames]
        self.can_move: Flags = self._movable(frame_ids, resting)
        self.is_slow: Flags = np.isin(self._scene.types, (*_MAPS, SOLID))

    def is_of_now(self, context: SceneGraphContext) -> bool:
        """Return whether the scene of a context is still the same, but for poses."""
        return self._mark == _mark(context)

    def take_shapes(self, queries: MotionQueries) -> bool:
        """Take the shapes of now if nothing else changed, as when sensors change their maps.

        ``queries`` of this scene take them, too. Return False if more changed.
        """
        mark, state = _mark(self._context), state_of(self._context)
        world, padded = state.up_to_date_world(), state.paddings() is not None
        is_same = mark[1:] == self._mark[1:] and not (padded or self._scene.paddings.any())
        is_same &= np.array_equal(world.geometries.ids, self.ids)
        is_same &= np.array_equal(world.frames.ids, self._frame_ids)
        if not (is_same and queries.take_shapes_of(world)):
            return False
        table = world.geometries
        self._scene = replace(self._scene, starts=table.starts, pool=table.pool)
        self._mark = mark
        return True

    def relative(self, pairs: Indices) -> Flags:
        """Return which columns (k, c) move the bodies of pairs (k, 2) relative to each other.

        A column that moves both as one does not; one that leads several joints may.
        """
        a, b = self.moved_by[pairs[:, 0]], self.moved_by[pairs[:, 1]]
        return np.asarray((a ^ b) | ((a | b) & self._leads_several))

    def queries(self, pairs: Indices) -> StopQueries:
        """Return queries about stops of some pairs (k, 2), by place."""
        none = np.zeros((0, 2), dtype=np.int64)
        scene = replace(self._scene, pairs=np.ascontiguousarray(pairs), half_spaces=none)
        return StopQueries(scene, self._accuracy, self._chain, self.relative(pairs))

    def poses(self) -> tuple[Floats, Floats]:
        """Return R_PF (nf, 3, 3) and p_PF (nf, 3) of all frames now, by place."""
        world = state_of(self._context).up_to_date_world()
        return world.R_PFs, world.p_PFs

    def unplaced(self) -> Flags:
        """Return the geometries (n,) on frames that never had a pose, nor follow joints."""
        world = state_of(self._context).up_to_date_world()
        lost = ~world.placed
        lost[self._scene.moved] = False
        return np.asarray(lost[self._scene.frames])

    def _movable(self, frame_ids: Indices, resting: Collection[int]) -> Flags:
        """Return which geometries (n,) neither joints nor the world hold."""
        state = state_of(self._context)
        ids = state.up_to_date_world().frames.ids
        driven = np.isin(ids, frame_ids)
        held = driven | np.isin(ids, [*state.filters.welded, *resting])
        stays, carried = np.zeros((2, len(ids)), dtype=np.bool_)
        stays[0] = True
        for frame, parent in enumerate(self._scene.parents.tolist()):
            if frame:  # what hangs on a link moves with that alone
                stays[frame] = stays[parent] and (held[frame] or carried[parent])
                carried[frame] = driven[frame] or carried[parent]
        is_map = np.isin(self._scene.types, _MAPS)
        return ~stays[self._scene.frames] | is_map


def _mark(context: SceneGraphContext) -> tuple[object, ...]:
    state = state_of(context)
    return state.model.versions.any, state.filters.version, frozenset(state.filters.welded)


def _leads_several(chain: JointChain, columns: int) -> Flags:
    """Return the mask (c,) of the columns that lead several joints, other than in a row."""
    leads = np.zeros(columns, dtype=np.bool_)
    last = np.full(columns, -1, dtype=np.int64)  # the link below the last joint of each column
    for j, leader in enumerate(chain.leaders.tolist()):
        if leader >= 0 and chain.kinds[j]:
            leads[leader] |= last[leader] not in (-1, chain.parents[j])
            last[leader] = chain.children[j]
    return leads


def _columns_of_frames(scene: PackedScene, chain: JointChain, columns: int) -> Flags:
    """Return the mask (nf, c) of the columns that move each frame in the world."""
    of_links = np.zeros((len(chain.X_WLs), columns), dtype=np.bool_)
    for j, (parent, child) in enumerate(zip(chain.parents, chain.children, strict=True)):
        of_links[child] |= of_links[parent]
        if chain.kinds[j] and chain.leaders[j] >= 0:
            of_links[child, chain.leaders[j]] = True
    of_frames = np.zeros((len(scene.parents), columns), dtype=np.bool_)
    links = dict(zip(scene.moved.tolist(), chain.links.tolist(), strict=True))
    for frame, parent in enumerate(scene.parents.tolist()):
        if frame:
            of_frames[frame] = of_frames[parent]
        if frame in links:
            of_frames[frame] |= of_links[links[frame]]
    return of_frames
