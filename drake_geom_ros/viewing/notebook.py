"""Pictures of scenes as results of notebook cells."""

from __future__ import annotations

import io
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.common.whole_files import whole_file
from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    FramePoseVector,
    GeometryError,
    GeometryId,
    QueryObject,
    Role,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.sensors import CameraInfo
from drake_geom_ros.viewing.looks import geometry_name
from drake_geom_ros.viewing.shown_contacts import contacts_of
from drake_geom_ros.viewing.shown_pairs import ReportedPairs
from drake_geom_ros.viewing.snapshot import Camera, Pixels, camera_for, looking, picture

__all__ = ['NotebookPicture', 'show']


class _JointsOfStates(Protocol):
    """Protocol of joints of states, such as ``drake_geom_ros.batch.Joints``."""

    @property
    def frame_ids(self) -> list[FrameId]: ...
    def poses(self, states: NDArray[np.float64]) -> NDArray[np.float64]: ...


class NotebookPicture:
    """A picture that notebooks display, with ``pixels`` (height, width, 3)."""

    def __init__(self, pixels: Pixels) -> None:
        self.pixels = pixels  # (height, width, 3) uint8

    def _repr_png_(self) -> bytes:
        """Return the picture as PNG; notebooks call this."""
        try:
            from PIL import Image
        except ImportError as error:
            raise GeometryError(f'pictures need pillow ({error}): pip install pillow') from None
        file = io.BytesIO()
        Image.fromarray(self.pixels).save(file, 'PNG')
        return file.getvalue()

    def save(self, path: str | Path) -> None:
        """Write the picture as PNG."""
        with whole_file(Path(path), 'wb') as file:
            file.write(self._repr_png_())


def show(
    scene: SceneGraph | SceneGraphContext | QueryObject,
    joints: _JointsOfStates | None = None,
    q: ArrayLike | None = None,
    *,
    max_distance: float = 0.05,
    nearest: int = 10,
    see_through: float = 0.4,
    from_W: Sequence[float] | None = None,
    at_W: Sequence[float] | None = None,
    size: tuple[int, int] = (640, 480),
    fov_y: float = 0.6,
    role: Role = Role.kProximity,
    contacts: bool = False,
) -> NotebookPicture:
    """Return a picture of a scene at its current poses, or in a state q (c,) of some joints.

    Args:
        scene: A scene graph, a context or a query object; with ``q`` not a query object.
        joints: The joints of ``q``.
        q: Joint values (c,) [rad] or [m].
        max_distance: Pairs up to this distance [m] are drawn as lines between their nearest
            points, orange if they overlap; a negative one draws none.
        nearest: The maximum number of pairs that are drawn, the nearest ones.
        see_through: Opacity of bodies, in (0, 1].
        from_W: Position (3,) [m] of the camera; by default it sees the whole scene.
        at_W: Point (3,) [m] that the camera looks at.
        size: Width and height [pixels].
        fov_y: Vertical field of view [rad].
        role: The role of the visible geometries.
        contacts: Whether to draw contact surfaces, coloured by pressure; pairs that overlap
            without a surface are a warning.

    Raises:
        PoseError: Frames have no pose.
        ArgumentError: Arguments do not go together, or there is nothing to show.
    """
    if (joints is None) != (q is None) or (from_W is None) != (at_W is None):
        raise ArgumentError('joints and q go together, and from_W and at_W')
    query = _query(scene) if joints is None else _in_state(scene, joints, q)
    if not query.inspector().NumGeometriesWithRole(role):
        raise ArgumentError(f'no geometry of this scene has the role {role.name}: nothing to show')
    if from_W is None or at_W is None:
        camera = camera_for(query, role, size, fov_y)
    else:
        camera = Camera(looking(from_W, at_W), CameraInfo(*size, fov_y))
    pairs = None
    if max_distance >= 0.0:
        reported = query.ComputeSignedDistancePairwiseClosestPoints(max_distance)
        pairs = ReportedPairs.of(reported).rows(slice(nearest))
    patches = None
    if contacts:
        inspector = query.inspector()
        patches, _, missing = contacts_of(
            query, lambda id: geometry_name(inspector, GeometryId(id))
        )
        for remark in missing:
            warnings.warn(f'show: {remark}', stacklevel=2)
    return NotebookPicture(picture(query, camera, role, see_through, pairs, patches))


def _in_state(scene: Any, joints: _JointsOfStates, q: Any) -> QueryObject:
    """Return a query object of a copy of the scene with other joint values."""
    if not isinstance(scene, (SceneGraph, SceneGraphContext)):
        raise ArgumentError(
            'joints and q go with a scene graph or a context, which is copied and posed; '
            f'given {scene!r}'
        )
    other = scene.CreateDefaultContext() if isinstance(scene, SceneGraph) else scene.copy()
    (poses,) = joints.poses(np.asarray(q, dtype=np.float64)[None])
    other.UpdateFramePoses(FramePoseVector.FromArrays(joints.frame_ids, poses))
    return QueryObject(other)


def _query(scene: Any) -> QueryObject:
    if isinstance(scene, QueryObject):
        return scene
    if isinstance(scene, SceneGraph):
        return QueryObject(scene.CreateDefaultContext())
    if isinstance(scene, SceneGraphContext):
        return QueryObject(scene)
    raise ArgumentError(f'a scene graph, a context or a query object is shown, not {scene!r}')
