"""Cameras as pydrake described them in 2020."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drake_geom_ros.geometry.render.cameras import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    RenderCameraCore,
)
from drake_geom_ros.geometry.render.tolerances import NEAREST_SURFACE
from drake_geom_ros.sensors import CameraInfo


@dataclass
class CameraProperties:
    """A camera by its size [pixels], vertical field of view [rad] and the renderer it asks.

    It sees whatever is farther than a micrometre before it. Values are checked when an image is
    asked for.
    """

    width: int
    height: int
    fov_y: float
    renderer_name: str

    def _core(self) -> RenderCameraCore:
        """Return the same camera as it is described today."""
        intrinsics = CameraInfo(self.width, self.height, self.fov_y)
        clipping = ClippingRange(NEAREST_SURFACE, math.inf)
        return RenderCameraCore(self.renderer_name, intrinsics, clipping)


@dataclass
class DepthCameraProperties(CameraProperties):
    """A depth camera, which tells depths from ``z_near`` to ``z_far`` [m]."""

    z_near: float
    z_far: float


def depth_camera_of(camera: DepthCameraProperties) -> DepthRenderCamera:
    """Return the same camera as it is described today."""
    return DepthRenderCamera(core_of(camera), DepthRange(camera.z_near, camera.z_far))


Camera = CameraProperties | ColorRenderCamera | DepthRenderCamera


def core_of(camera: Camera) -> RenderCameraCore:
    """Return what a camera of either description shares with all."""
    return camera._core() if isinstance(camera, CameraProperties) else camera.core()
