"""A picture of a scene where a notebook's cell ends with it."""

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
from drake_geom_ros.viewing.contacts import contacts_of
from drake_geom_ros.viewing.looks import geometry_name
from drake_geom_ros.viewing.pairs import Pairs
from drake_geom_ros.viewing.snapshot import Camera, Pixels, camera_for, looking, picture


class _Joints(Protocol):
    """Joints of states, as ``drake_geom_ros.batch.Joints`` is."""

    @property
    def frame_ids(self) -> list[FrameId]: ...
    def poses(self, states: NDArray[np.float64]) -> NDArray[np.float64]: ...


class Shown:
    """A picture, which notebooks show: ``pixels`` (height, width, 3), and how to keep it."""

    def __init__(self, pixels: Pixels) -> None:
        self.pixels = pixels  # (height, width, 3) uint8

    def _repr_png_(self) -> bytes:
        """Return the picture as notebooks ask for it."""
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
    joints: _Joints | None = None,
    q: ArrayLike | None = None,
    *,
    max_distance: float = 0.05,
    see_through: float = 0.4,
    from_W: Sequence[float] | None = None,
    at_W: Sequence[float] | None = None,
    size: tuple[int, int] = (640, 480),
    fov_y: float = 0.6,
    role: Role = Role.kProximity,
    contacts: bool = False,
) -> Shown:
    """Return a picture of a scene as it stands, or in a state q (c,) of some joints.

    The pairs up to ``max_distance`` [m] are drawn by their nearest points, red where they overlap;
    a negative one draws none. ``contacts`` draws the contact surfaces, coloured by pressure; what
    they do not show is a warning. ``see_through`` is how much of a body covers what is behind it.
    The camera is at ``from_W`` and looks at ``at_W`` (3,) [m], or has all of the scene in sight.
    Raises PoseError for frames without a pose, ArgumentError for what cannot be shown.
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
        pairs = Pairs.of(query.ComputeSignedDistancePairwiseClosestPoints(max_distance))
    patches = None
    if contacts:
        inspector = query.inspector()
        patches, _, missing = contacts_of(
            query, lambda id: geometry_name(inspector, GeometryId(id))
        )
        for remark in missing:
            warnings.warn(f'show: {remark}', stacklevel=2)
    return Shown(picture(query, camera, role, see_through, pairs, patches))


def _in_state(scene: Any, joints: _Joints, q: Any) -> QueryObject:
    """Return a query object of a copy in which the joints have other values."""
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
