"""Camera descriptions with pydrake's names of 2020."""

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
from drake_geom_ros.geometry.tolerances import NEAREST_SURFACE
from drake_geom_ros.sensors import CameraInfo


@dataclass
class CameraProperties:
    """A camera by its size [pixels], vertical field of view [rad] and renderer.

    It sees surfaces from a distance of a micrometre on. Values are checked when an image is made.
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
    """A depth camera, which measures depths from ``z_near`` to ``z_far`` [m]."""

    z_near: float
    z_far: float


def depth_camera_of(camera: DepthCameraProperties) -> DepthRenderCamera:
    """Return the same camera as it is described today."""
    return DepthRenderCamera(core_of(camera), DepthRange(camera.z_near, camera.z_far))


Camera = CameraProperties | ColorRenderCamera | DepthRenderCamera


def core_of(camera: Camera) -> RenderCameraCore:
    """Return the core of a camera of either description."""
    return camera._core() if isinstance(camera, CameraProperties) else camera.core()
