"""Messages to what the demo works with; any objects with the messages' fields will do."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.ros.conversions.fields import seconds_of
from drake_geom_ros.ros.demo.recording import Approach
from drake_geom_ros.ros.demo.scene_table import WORLD, Geometry, SceneTable
from drake_geom_ros.trajectories.pose_matrices import matrices_of_poses

Floats = NDArray[np.float64]
# Things closer than this [m] at the beginning of the motion are taken to touch by construction.
TOUCHING = 0.0005


def scene_table(message: Any) -> SceneTable:
    """Return the geometries of a Scene message."""
    sources = {source.id: source.name for source in message.sources}
    frames = _frame_names(message)
    geometries = []
    for entry in message.geometries:
        p, q = entry.pose.position, entry.pose.orientation
        geometries.append(
            Geometry(
                entry.id,
                sources[entry.source_id],
                frames[entry.frame_id],
                entry.name,
                entry.shape.type,
                tuple(entry.shape.dimensions),
                matrices_of_poses([p.x, p.y, p.z, q.x, q.y, q.z, q.w]),
            )
        )
    return SceneTable(geometries, message.scene_version)


def frame_parents(message: Any) -> dict[str, str]:
    """Return the parent of each frame of a Scene message by name, parents first."""
    names = _frame_names(message)
    return {
        names[frame.id]: names[frame.parent_id]
        for frame in message.frames
        if names[frame.id] != WORLD
    }


def _frame_names(message: Any) -> dict[int, str]:
    sources = {source.id: source.name for source in message.sources}
    return {
        frame.id: WORLD
        if frame.parent_id == frame.id
        else f'{sources[frame.source_id]}::{frame.name}'
        for frame in message.frames
    }


def world_poses(message: Any, parents: dict[str, str]) -> dict[str, Floats]:
    """Return X_WF (4, 4) of the frames of a FramePoses message by ``source::frame``."""
    names = [f'{message.source}::{n}' if message.source else n for n in message.frame_names]
    X_PFs = dict(zip(names, matrices_of_poses(np.reshape(message.poses, (-1, 7))), strict=True))
    X_WFs: dict[str, Floats] = {WORLD: np.eye(4)}
    for name, parent in parents.items():
        if name in X_PFs and parent in X_WFs:
            X_WFs[name] = X_WFs[parent] @ X_PFs[name]
    return X_WFs


def approach(message: Any, k: int, table: SceneTable, X_WFs: dict[str, Floats]) -> Approach:
    """Return pair ``k`` of a SignedDistancePairs message with its witnesses in the world."""

    def in_world(ids: Any, witnesses: Any) -> Floats:
        geometry = table[ids[k]]
        X_WG = X_WFs[geometry.frame] @ geometry.X_FG
        return np.asarray((X_WG @ [*witnesses[3 * k : 3 * k + 3], 1.0])[:3])

    return Approach(
        stamp(message),
        int(message.id_a[k]),
        int(message.id_b[k]),
        float(message.distance[k]),
        in_world(message.id_a, message.p_aca),
        in_world(message.id_b, message.p_bcb),
        np.array(message.nhat_ba_w[3 * k : 3 * k + 3]),
        X_WFs,
    )


def touching(message: Any, table: SceneTable) -> list[tuple[Geometry, Geometry]]:
    """Return the pairs of a SignedDistancePairs message that touch, one for each two things."""
    things: dict[str, tuple[Geometry, Geometry]] = {}
    for a, b, distance in zip(message.id_a, message.id_b, message.distance, strict=True):
        if distance < TOUCHING:
            things.setdefault(table.pair_name(a, b), (table[a], table[b]))
    return list(things.values())


def stamp(message: Any) -> float:
    """Return the stamp [s] of a message."""
    return seconds_of(message.header.stamp)
