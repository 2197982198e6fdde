"""Cameras, labels and renderers, with the names of ``pydrake.geometry.render``.

Renderers draw colour, depth and label images of a scene from the pose of a camera.
"""

from drake_geom_ros.geometry.render.camera_properties import (
    CameraProperties,
    DepthCameraProperties,
)
from drake_geom_ros.geometry.render.cameras import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    RenderCameraCore,
)
from drake_geom_ros.geometry.render.render_engine import RenderedImages, RenderEngine
from drake_geom_ros.geometry.render.render_label import RenderLabel

__all__ = [
    'CameraProperties',
    'DepthCameraProperties',
    'ClippingRange',
    'ColorRenderCamera',
    'DepthRange',
    'DepthRenderCamera',
    'RenderCameraCore',
    'RenderEngine',
    'RenderLabel',
    'RenderedImages',
]
