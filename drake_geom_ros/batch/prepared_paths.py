"""Prepared data of path checks, cached in a context for later checks of the same scene."""

from __future__ import annotations

from collections.abc import Hashable
from typing import NamedTuple

import numpy as np

from drake_geom_ros.batch.joints import Joints, chain_of_arms, still_poses
from drake_geom_ros.geometry import Accuracy, SceneGraphContext
from drake_geom_ros.geometry.queries.context import state_of
from drake_geom_ros.geometry.queries.joint_trees import JointChain
from drake_geom_ros.geometry.queries.motion_queries import MotionQueries
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.math.array_types import Indices


class PreparedPaths(NamedTuple):
    """A scene and joints prepared for path checks, used by one checker at a time."""

    scene: PackedScene
    ids: Indices  # (n,) of its geometries, by their place
    chain: JointChain
    queries: MotionQueries  # of one thread
    stop: Indices  # (1,) the flag that ends these queries, and those of other threads


def take(
    context: SceneGraphContext, joints: Joints, accuracy: Accuracy
) -> tuple[Hashable, PreparedPaths]:
    """Return a cache key, and prepared data for paths of joints in a context's current scene.

    Cached data is reused for the same content and filters, the same joints, and the same poses of
    all frames that they do not move. Raises PoseError for frames without a pose.
    """
    state, chain = state_of(context), chain_of_arms(joints.arms)
    world = state.up_to_date_world()
    others = ~np.isin(world.frames.ids, joints.id_values)
    kind = (
        *('paths', accuracy, joints.count, state.model.versions.any, state.filters.version),
        *(frozenset(state.filters.welded), joints.id_values.tobytes()),
        *(array.tobytes() for array in chain),
        *(world.R_PFs[others].tobytes(), world.p_PFs[others].tobytes()),
    )
    prepared = None
    if np.isin(world.unposed_frames(), joints.id_values).all():
        prepared = state.prepared_motions.take(kind)
    if prepared is None:
        still = still_poses(joints.arms, joints.id_values)
        scene, ids = PackedScene.of(context, joints.id_values, still, about_points=False)
        stop = np.zeros(1, dtype=np.int64)
        queries = MotionQueries(scene, accuracy, stop, chain, joints.count)
        prepared = PreparedPaths(scene, ids, chain, queries, stop)
    return kind, prepared


def give_back(context: SceneGraphContext, kind: Hashable, prepared: PreparedPaths) -> None:
    """Return prepared data to the cache."""
    state_of(context).prepared_motions.keep(kind, prepared)
