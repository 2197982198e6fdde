"""The frame that a sensor measured in: one of the scene, or of TF, which hangs on one.

Static transforms of TF hold at any time. Of others the newest is not that of a stamp: they are
kept from when a message named them first, which is refused while nothing is known of its time.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from drake_geom_ros.geometry import ArgumentError, FrameId
from drake_geom_ros.live.conversions.names import UnknownNameError
from drake_geom_ros.live.conversions.transforms import plain_name
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.math import RigidTransform, RotationMatrix


class SensorFrames:
    """Finds the frames that messages of sensors name."""

    def __init__(self, tf: Callable[[], TfInput | None]) -> None:
        """``tf()`` is what is known of TF; None: nobody listens to it."""
        self._tf = tf

    def __call__(
        self, scene: HeldScene, name: str, held: float
    ) -> tuple[FrameId, RigidTransform] | str:
        """Return a frame of the scene, and the pose in it of what is called so, at a time [s].

        A text names what is not known of that time yet. Raises ArgumentError for a name that
        nothing bears, and where it never will be known.
        """
        if not name:
            raise ArgumentError('header.frame_id is empty; it names the frame of the sensor')
        try:
            frame = scene.model.names.frame(name)
        except UnknownNameError as unknown:
            problem = str(unknown)
        else:
            if frame not in scene.model.names.of_maps:
                return frame, RigidTransform()
            problem = f'{name[:80]!r} is the frame of a sensed map, which no sensor is on'
        tf = self._tf()
        ends = _ends(scene)
        here = plain_name(name)
        X_PF, seen = RigidTransform(), {here}
        while here not in ends:
            edge = None if tf is None else tf.edge(here)
            if tf is None or edge is None:
                where = f'; nor does TF lead from it to a frame of the scene ({here[:80]!r})'
                raise ArgumentError(problem + (where if tf is not None else '; use_tf is false'))
            if np.isfinite(edge.stamp):
                step = tf.at(here, held)
                if isinstance(step, str):
                    return step
            else:
                step = RigidTransform(RotationMatrix(edge.R_PC), edge.p_PC)
            X_PF = step @ X_PF
            here = edge.parent
            if here in seen:
                raise ArgumentError(f'the transforms of TF above {name[:80]!r} are a loop')
            seen.add(here)
        return ends[here], X_PF


def _ends(scene: HeldScene) -> dict[str, FrameId]:
    """Return the frames of the scene by the names that TF has for them."""
    alone = {name: own[0] for name, own in scene.model.names.tf_claims.items() if len(own) == 1}
    return {**alone, scene.model.world_frame: scene.model.names.world}
