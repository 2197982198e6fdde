"""``GeometryFrame`` and ``GeometryInstance``: definitions for registration in ``SceneGraph``."""

from __future__ import annotations

import copy
from typing import Any

from drake_geom_ros.geometry.checks import _T, canonical_name, checked_pose, checked_type
from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.ids import FrameId, GeometryId
from drake_geom_ros.geometry.model.properties import (
    IllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
)
from drake_geom_ros.geometry.shapes.primitives import Shape
from drake_geom_ros.math import RigidTransform


class GeometryFrame:
    """The definition of a frame: a name, unique within its source, and a group number >= 0.

    It gets its id when it is made, and the registered frame has the same id.
    """

    __slots__ = ('_frame_group', '_id', '_name')

    def __init__(self, frame_name: str, frame_group_id: int = 0) -> None:
        self._name = canonical_name(frame_name, 'GeometryFrame')
        if int(frame_group_id) != frame_group_id or frame_group_id < 0:
            raise ArgumentError(
                f'GeometryFrame {frame_name!r}: frame_group_id = {frame_group_id} must be an '
                'integer >= 0'
            )
        self._frame_group = int(frame_group_id)
        self._id = FrameId.get_new_id()

    def id(self) -> FrameId:
        """Return the id, the same in every copy."""
        return self._id

    def name(self) -> str:
        """Return the name, trimmed of spaces and tabs."""
        return self._name

    def frame_group(self) -> int:
        """Return the group number."""
        return self._frame_group


class GeometryInstance:
    """The definition of a geometry: pose X_PG in its parent, shape, name and properties by role.

    The parent P is a frame or another geometry. The name is trimmed of spaces and tabs; an empty
    one raises RuntimeError. It gets its id when it is made, and the registered geometry has the
    same id.

        >>> ball = GeometryInstance(RigidTransform([0, 0, 1]), Sphere(0.1), 'ball')
        >>> ball.set_proximity_properties(ProximityProperties())
    """

    __slots__ = ('_X_PG', '_id', '_illustration', '_name', '_perception', '_proximity', '_shape')

    def __init__(self, X_PG: RigidTransform, shape: Shape, name: str) -> None:
        self._X_PG = checked_pose(X_PG, 'GeometryInstance: X_PG')
        self._shape = checked_type(shape, Shape, 'GeometryInstance: shape')
        self._name = canonical_name(name, 'GeometryInstance')
        self._id = GeometryId.get_new_id()
        self._proximity: ProximityProperties | None = None
        self._illustration: IllustrationProperties | None = None
        self._perception: PerceptionProperties | None = None

    def __copy__(self) -> GeometryInstance:
        """Return an independent copy with the same id."""
        other = GeometryInstance.__new__(GeometryInstance)
        for name in GeometryInstance.__slots__:
            setattr(other, name, getattr(self, name))
        other._proximity = copy.copy(self._proximity)
        other._illustration = copy.copy(self._illustration)
        other._perception = copy.copy(self._perception)
        return other

    def __deepcopy__(self, memo: dict[int, Any]) -> GeometryInstance:
        return self.__copy__()

    def id(self) -> GeometryId:
        """Return the id, the same in every copy."""
        return self._id

    def name(self) -> str:
        """Return the name, trimmed of spaces and tabs."""
        return self._name

    def set_name(self, name: str) -> None:
        """Set the name."""
        self._name = canonical_name(name, 'GeometryInstance')

    def pose(self) -> RigidTransform:
        """Return X_PG, the pose in the parent."""
        return RigidTransform(self._X_PG)

    def set_pose(self, X_PG: RigidTransform) -> None:
        """Set the pose in the parent."""
        self._X_PG = checked_pose(X_PG, 'GeometryInstance: X_PG')

    def shape(self) -> Shape:
        """Return the shape."""
        return self._shape

    def release_shape(self) -> Shape:
        """Return the shape; shapes are immutable, so the instance keeps it."""
        return self._shape

    def set_proximity_properties(self, properties: ProximityProperties) -> None:
        """Copy the properties; the registered geometry has the proximity role."""
        self._proximity = _copied(properties, ProximityProperties)

    def set_illustration_properties(self, properties: IllustrationProperties) -> None:
        """Copy the properties; the registered geometry has the illustration role."""
        self._illustration = _copied(properties, IllustrationProperties)

    def set_perception_properties(self, properties: PerceptionProperties) -> None:
        """Copy the properties; the registered geometry has the perception role."""
        self._perception = _copied(properties, PerceptionProperties)

    def proximity_properties(self) -> ProximityProperties | None:
        """Return the properties of the proximity role, or None."""
        return self._proximity

    def illustration_properties(self) -> IllustrationProperties | None:
        """Return the properties of the illustration role, or None."""
        return self._illustration

    def perception_properties(self) -> PerceptionProperties | None:
        """Return the properties of the perception role, or None."""
        return self._perception

    def mutable_proximity_properties(self) -> ProximityProperties | None:
        """Return the properties of the proximity role for changing, or None."""
        return self._proximity

    def mutable_illustration_properties(self) -> IllustrationProperties | None:
        """Return the properties of the illustration role for changing, or None."""
        return self._illustration

    def mutable_perception_properties(self) -> PerceptionProperties | None:
        """Return the properties of the perception role for changing, or None."""
        return self._perception


def _copied(properties: Any, kind: type[_T]) -> _T:
    """Return a copy of properties; raises an error for those of another role."""
    checked: Any = checked_type(properties, kind, 'GeometryInstance: properties')
    return kind(checked)  # type: ignore[call-arg]
