"""Cameras, labels and renderers: the names of ``pydrake.geometry.render``.

In: cameras and a packed scene.
Out: images, by the renderer that was asked for.
May import: ``math``, ``common``, ``geometry``, ``meshes``, ``shapes``, ``hydroelastic``,
    ``model``, ``sensors``,
    ``_proximity``, ``_rendering``; numpy.
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
