"""Poses of frames as text, in the format of scene files or of pose files."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping

import yaml

from drake_geom_ros.common.frame_names import Frame, FrameNames, full_name
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.yaml_values import plain_pose

_COLUMNS = ('frame', 'x', 'y', 'z', 'qx', 'qy', 'qz', 'qw')


def as_yaml(X_PFs: Mapping[Frame, RigidTransform]) -> str:
    """Return poses of frames in their parents as text of a scene file."""
    frames = [
        {'name': name, 'source': source, 'pose': plain_pose(X_PF)}
        for (source, name), X_PF in X_PFs.items()
    ]
    text: str = yaml.safe_dump({'frames': frames}, sort_keys=False, default_flow_style=None)
    return text


def as_csv(X_PFs: Mapping[Frame, RigidTransform]) -> str:
    """Return poses of frames in their parents as text of a pose file.

    Raises AmbiguousNameError if two frames share a name ``source::frame``.
    """
    names = FrameNames(X_PFs)
    file = io.StringIO()
    writer = csv.writer(file, lineterminator='\n')
    writer.writerow(_COLUMNS)
    for frame, X_PF in X_PFs.items():
        names.find(name := full_name(frame))
        writer.writerow([name, *X_PF.ToArray().tolist()])
    return file.getvalue()
