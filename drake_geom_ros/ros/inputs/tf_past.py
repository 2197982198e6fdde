"""What transforms of TF were in the last seconds, of those that somebody asked about. No ROS."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.batched import poses_from_matrices
from drake_geom_ros.ros.inputs.tf_edges import Edge
from drake_geom_ros.ros.scene.pose_history import PoseHistory


class TfPast:
    """Keeps moving transforms by the name of their child."""

    def __init__(self) -> None:
        self._watched: dict[str, PoseHistory] = {}

    def note(self, child: str, edge: Edge) -> None:
        """Keep a transform, if it was asked about before."""
        if (history := self._watched.get(child)) is not None:
            rows = poses_from_matrices([edge.R_PC], [edge.p_PC])
            history.note(np.array([0]), rows, {frozenset([0]): edge.since})

    def at(self, child: str, held: float) -> RigidTransform | str:
        """Return X_PC at a time [s], or the name of the child where it is not known yet.

        Raises ArgumentError where it will never be.
        """
        history = self._watched.get(child)
        if history is None:
            self._watched[child] = PoseHistory()
            return child
        then = history.at(held, [0])
        if then.lost and history.begins_before(held):
            raise ArgumentError(
                f'of the time of the stamp TF tells no transform of {child[:80]!r}'
            )
        return RigidTransform.FromArray(then.rows[0]) if len(then.rows) else child
