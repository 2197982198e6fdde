"""Messages to what the demo works with; any objects with the messages' fields will do."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.client.results import SignedDistance, SignedDistances
from drake_geom_ros.client.scene_table import Geometry, SceneTable
from drake_geom_ros.common.frame_names import Frame, FrameNames
from drake_geom_ros.live.conversions.fields import seconds_of
from drake_geom_ros.ros.demo.recording import Approach
from drake_geom_ros.trajectories.pose_matrices import matrices_of_poses

Floats = NDArray[np.float64]
Poses = Mapping[Frame, Floats]  # X_WF (4, 4) of frames, not of the world
# Things closer than this [m] at the beginning of the motion are taken to touch by construction.
TOUCHING = 0.0005


def world_poses(message: Any, parents: Mapping[Frame, Frame | None]) -> Poses:
    """Return X_WF (4, 4) of the frames of a FramePoses message; ``parents`` as a table has them.

    Raises AmbiguousNameError for a text that two frames bear, as the node refuses it.
    """
    names = FrameNames(parents)
    texts = message.frame_names
    frames = [(message.source, n) if message.source else names.find(n) for n in texts]
    X_PFs = dict(zip(frames, matrices_of_poses(np.reshape(message.poses, (-1, 7))), strict=True))
    X_WFs: dict[Frame, Floats] = {}
    for frame, parent in parents.items():
        if frame in X_PFs and (parent is None or parent in X_WFs):
            X_PF = X_PFs[frame]
            X_WFs[frame] = X_PF if parent is None else X_WFs[parent] @ X_PF
    return X_WFs


def approach(pair: SignedDistance, time: float, table: SceneTable, X_WFs: Poses) -> Approach:
    """Return a pair at a time [s] with its witnesses in the world."""

    def in_world(id: int, p_GQ: Floats) -> Floats:
        return np.asarray((table[id].X_WG(X_WFs) @ [*p_GQ, 1.0])[:3])

    return Approach(
        time,
        pair.id_a,
        pair.id_b,
        pair.distance,
        in_world(pair.id_a, pair.p_ACa),
        in_world(pair.id_b, pair.p_BCb),
        pair.nhat_BA_W,
        X_WFs,
    )


def touching(distances: SignedDistances) -> list[tuple[Geometry, Geometry]]:
    """Return the pairs of a result that touch, one for each two things."""
    things: dict[str, tuple[Geometry, Geometry]] = {}
    table = distances.table
    for pair in distances:
        if pair.distance < TOUCHING:
            both = table[pair.id_a], table[pair.id_b]
            things.setdefault(table.pair_name(pair.id_a, pair.id_b), both)
    return list(things.values())


def stamp(message: Any) -> float:
    """Return the stamp [s] of a message."""
    return seconds_of(message.header.stamp)
