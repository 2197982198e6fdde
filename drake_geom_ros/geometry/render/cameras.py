"""Cameras: intrinsics, clipping, pose of the sensor, and renderer."""

from __future__ import annotations

import math
from typing import Any, TypeVar

from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensors import CameraInfo

_T = TypeVar('_T')


class _Range:
    """Two depths [m], the smaller one first."""

    __slots__ = ('_far', '_near')
    _near: float
    _far: float
    _NAMES = ('near', 'far')

    def _take(self, near: Any, far: Any, other: Any) -> None:
        if (same := _copied(self, other, near, far)) is not None:
            near, far = same._near, same._far
        self._near, self._far = _number(self, near), _number(self, far)
        if not 0.0 < self._near < self._far or math.isinf(self._near):
            first, second = self._NAMES
            raise ArgumentError(
                f'{type(self).__name__}: {first} = {near} and {second} = {far} must be '
                f'0 < {first} < {second} [m]'
            )

    def __eq__(self, other: object) -> bool:
        if not (isinstance(other, _Range) and type(other) is type(self)):
            return NotImplemented
        return (self._near, self._far) == (other._near, other._far)

    def __hash__(self) -> int:
        return hash((self._near, self._far))

    def __repr__(self) -> str:
        return f'{type(self).__name__}({self._near!r}, {self._far!r})'


class ClippingRange(_Range):
    """Clipping planes: surfaces at depths [m] from ``near`` to ``far`` are visible.

    Depth is z in the sensor's frame. ``far`` may be infinite. As for all classes here, another
    range as the only argument, first or as ``other``, is copied. Raises RuntimeError unless
    0 < near < far.
    """

    __slots__ = ()

    def __init__(
        self,
        near: float | ClippingRange | None = None,
        far: float | None = None,
        *,
        other: ClippingRange | None = None,
    ) -> None:
        self._take(near, far, other)

    def near(self) -> float:
        """Return the smallest visible depth [m]."""
        return self._near

    def far(self) -> float:
        """Return the largest visible depth [m]."""
        return self._far


class DepthRange(_Range):
    """Range of depths [m] in a depth image, which has 0 below it and infinity above.

    The keywords are pydrake's: ``min_in`` is the smallest depth [m], ``min_out`` the largest.
    Raises RuntimeError unless 0 < min_in < min_out.
    """

    __slots__ = ()
    _NAMES = ('min_depth', 'max_depth')

    def __init__(
        self,
        min_in: float | DepthRange | None = None,
        min_out: float | None = None,
        *,
        other: DepthRange | None = None,
    ) -> None:
        self._take(min_in, min_out, other)

    def min_depth(self) -> float:
        """Return the smallest measured depth [m]."""
        return self._near

    def max_depth(self) -> float:
        """Return the largest measured depth [m]."""
        return self._far


class RenderCameraCore:
    """Common part of colour and depth cameras.

    ``X_BS`` is the pose of the sensor S in the camera's body B: with the identity the camera
    looks along +z of its body.
    """

    __slots__ = ('_X_BS', '_clipping', '_intrinsics', '_renderer_name')
    _renderer_name: str
    _intrinsics: CameraInfo
    _clipping: ClippingRange
    _X_BS: RigidTransform

    def __init__(
        self,
        renderer_name: str | RenderCameraCore | None = None,
        intrinsics: CameraInfo | None = None,
        clipping: ClippingRange | None = None,
        X_BS: RigidTransform | None = None,
        *,
        other: RenderCameraCore | None = None,
    ) -> None:
        same = _copied(self, other, renderer_name, intrinsics, clipping, X_BS)
        if same is not None:
            renderer_name, X_BS = same._renderer_name, same._X_BS
            intrinsics, clipping = same._intrinsics, same._clipping
        self._renderer_name = _of_type(self, 'renderer_name', renderer_name, str)
        self._intrinsics = _of_type(self, 'intrinsics', intrinsics, CameraInfo)
        self._clipping = _of_type(self, 'clipping', clipping, ClippingRange)
        X = RigidTransform() if X_BS is None else _of_type(self, 'X_BS', X_BS, RigidTransform)
        self._X_BS = RigidTransform(X)

    def renderer_name(self) -> str:
        """Return the name of the camera's renderer."""
        return self._renderer_name

    def intrinsics(self) -> CameraInfo:
        """Return the intrinsics."""
        return self._intrinsics

    def clipping(self) -> ClippingRange:
        """Return the range of visible depths."""
        return self._clipping

    def sensor_pose_in_camera_body(self) -> RigidTransform:
        """Return X_BS."""
        return RigidTransform(self._X_BS)


class ColorRenderCamera:
    """A camera that takes colour and label images; it has no window."""

    __slots__ = ('_core',)
    _core: RenderCameraCore

    def __init__(
        self,
        core: RenderCameraCore | ColorRenderCamera | None = None,
        show_window: bool = False,
        *,
        other: ColorRenderCamera | None = None,
    ) -> None:
        if (same := _copied(self, other, core, show_window or None)) is not None:
            core = same._core
        self._core = _of_type(self, 'core', core, RenderCameraCore)
        refuse_window(show_window)

    def core(self) -> RenderCameraCore:
        """Return what all cameras have."""
        return self._core

    def show_window(self) -> bool:
        """Return False."""
        return False


class DepthRenderCamera:
    """A camera that takes depth images.

    Raises RuntimeError for a depth range that goes beyond the clipping range.
    """

    __slots__ = ('_core', '_depth_range')
    _core: RenderCameraCore
    _depth_range: DepthRange

    def __init__(
        self,
        core: RenderCameraCore | DepthRenderCamera | None = None,
        depth_range: DepthRange | None = None,
        *,
        other: DepthRenderCamera | None = None,
    ) -> None:
        if (same := _copied(self, other, core, depth_range)) is not None:
            core, depth_range = same._core, same._depth_range
        self._core = _of_type(self, 'core', core, RenderCameraCore)
        self._depth_range = _of_type(self, 'depth_range', depth_range, DepthRange)
        clipping = self._core.clipping()
        low, high = self._depth_range.min_depth(), self._depth_range.max_depth()
        if not clipping.near() <= low < high <= clipping.far():
            raise ArgumentError(
                f'DepthRenderCamera: {self._depth_range!r} must be within {clipping!r}, beyond '
                'which nothing is seen'
            )

    def core(self) -> RenderCameraCore:
        """Return what all cameras have."""
        return self._core

    def depth_range(self) -> DepthRange:
        """Return the range of measured depths."""
        return self._depth_range


def refuse_window(show_window: bool) -> None:
    """Raise RuntimeError if a window is requested, since there is none."""
    if show_window:
        raise ArgumentError(
            'show_window = True was asked for, and images are made without a screen: look at the '
            "image's data, at the files of `python -m drake_geom_ros render`, or at the topics of "
            'a camera of the node'
        )


def _number(camera: object, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ArgumentTypeError(
            f'{type(camera).__name__}: {value!r} must be a number [m]'
        ) from None


def _copied(camera: _T, other: Any, first: Any, *rest: Any) -> _T | None:
    """Return the camera to copy, ``other`` or a first argument of the same class, or None.

    Raises RuntimeError if there are other arguments beside it.
    """
    same = first if isinstance(first, type(camera)) else other
    if same is None:
        return None
    if sum(value is not None for value in (other, first, *rest)) > 1:
        raise ArgumentError(f'{type(camera).__name__}: give nothing beside what is to be copied')
    return _of_type(camera, 'other', same, type(camera))


def _of_type(camera: object, name: str, value: Any, kind: type[_T]) -> _T:
    if not isinstance(value, kind):
        what = f'{type(camera).__name__}: {name}'
        raise ArgumentTypeError(f'{what} = {value!r} must be of type {kind.__name__}')
    return value
