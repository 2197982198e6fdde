"""The service ``get_pose_ages``: ages of the poses of frames."""

from __future__ import annotations

import math
from typing import Any

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.scene.live_scene import LiveScene


def get_pose_ages(live: LiveScene, request: Any, response: Any) -> None:
    """Report the age of the pose of each frame, the oldest first."""
    with live.reading() as scene:
        names, inspector = scene.model.names, scene.model.inspector
        frames = list(dict.fromkeys(map(names.frame, request.frames)))
        if names.world in frames:
            raise ArgumentError('frames holds the world frame, which has no pose')
        frames = frames or list(names.labels)
        ages = scene.poses.ages_by_name()
        waiting = set(scene.query.waiting_frames())
        rows = [
            (
                ages[name := names.frame_names[frame]],
                frame not in waiting,
                name,
                frame.get_value(),
                inspector.GetParentFrame(frame).get_value() * inspector.IsAttached(frame),
            )
            for frame in frames
        ]
    for age, placed, name, value, carrier in sorted(rows, key=lambda row: (-row[0], row[1:3])):
        response.names.append(name)
        response.ids.append(value)
        response.ages.append(age if placed else math.inf)
        response.waiting.append(not placed)
        response.attached_to.append(carrier)
