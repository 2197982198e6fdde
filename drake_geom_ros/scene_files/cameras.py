"""Cameras of scene files: plain values to descriptions and back, and to render cameras."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from drake_geom_ros.geometry import (
    ClippingRange,
    DepthRange,
    DepthRenderCamera,
    MakeRenderEngineExact,
    RenderCameraCore,
    RenderEngineExactParams,
    Role,
    SceneGraph,
)
from drake_geom_ros.scene_files.description import (
    FAR,
    IMAGES,
    NEAR,
    PERCEPTION,
    RATE,
    WORLD,
    CameraDescription,
    Member,
)
from drake_geom_ros.scene_files.names import FileNames
from drake_geom_ros.scene_files.yaml_text import Document
from drake_geom_ros.scene_files.yaml_values import plain_pose, pose_of
from drake_geom_ros.sensors import CameraInfo

# Renderer name and geometry role by the key ``shows``.
RENDERERS = {
    'perception': ('exact', Role.kPerception),
    'proximity': ('exact_proximity', Role.kProximity),
}
DEFAULT_FOV_Y = 0.8  # [rad]
MOST_PIXELS = 16384  # along a side of an image
# Names of cameras become parts of topic names.
_NAME = re.compile(r'[A-Za-z][A-Za-z0-9_]*')


def read_cameras(document: Document, names: FileNames) -> tuple[CameraDescription, ...]:
    """Return the cameras of a document; raises SceneFileError for an invalid one."""
    cameras: dict[str, CameraDescription] = {}
    for index, plain in enumerate(document.value.get('cameras', ())):
        path = ('cameras', index)
        where = document.at(*path)
        if plain['name'] in cameras:
            raise where.error(f'camera {plain["name"]!r} is there twice')
        frame = plain.get('frame', WORLD)
        member = names.find(frame, document.at(*path, 'frame') if 'frame' in plain else where)
        if member.geometry is not None:
            raise document.at(*path, 'frame').error(f'{frame!r} is a geometry; give a frame')
        try:
            camera = CameraDescription(
                plain['name'],
                member.source,
                member.frame,
                pose_of(plain.get('pose')),
                _intrinsics(plain),
                (plain.get('near', NEAR), plain.get('far', FAR)),
                plain.get('rate', RATE),
                tuple(dict.fromkeys(plain.get('images', IMAGES))),
                plain.get('shows', PERCEPTION),
                where,
            )
            check_camera(camera)
        except RuntimeError as error:
            raise where.error(str(error)) from error
        cameras[camera.name] = camera
    return tuple(cameras.values())


def check_camera(camera: CameraDescription) -> None:
    """Raise RuntimeError, with the offending value, for an invalid camera."""
    if not _NAME.fullmatch(camera.name):
        raise RuntimeError(
            f'camera name {camera.name!r} must begin with a letter and hold letters, digits and '
            'underscores only: topics are named after it'
        )
    if not camera.images:
        raise RuntimeError(f'images is empty; it must hold some of {", ".join(IMAGES)}')
    for kind in camera.images:
        if kind not in IMAGES:
            raise RuntimeError(f'images holds {kind[:80]!r}; it must be of {", ".join(IMAGES)}')
    if camera.shows not in RENDERERS:
        raise RuntimeError(f'shows is {camera.shows[:80]!r}; it must be of {", ".join(RENDERERS)}')
    if not 0.0 < camera.rate < math.inf:
        raise RuntimeError(f'rate is {camera.rate}; it must be finite and > 0 [Hz]')
    if (size := max(camera.intrinsics.width(), camera.intrinsics.height())) > MOST_PIXELS:
        raise RuntimeError(f'an image has {size} rows or columns; {MOST_PIXELS} are the most')
    camera_of(camera)


def plain_camera(camera: CameraDescription, names: FileNames) -> dict[str, Any]:
    """Return the plain form of a camera, which reads back as exactly the same numbers."""
    on_world = camera.frame == WORLD
    frame = None if on_world else names.name(Member(camera.source, camera.frame))
    k = camera.intrinsics
    plain = {
        'name': camera.name,
        'frame': frame,
        'pose': plain_pose(camera.X_FC) or None,
        'size': [k.width(), k.height()],
        'intrinsics': [k.focal_x(), k.focal_y(), k.center_x(), k.center_y()],
        'near': camera.range[0],
        'far': camera.range[1],
        'rate': camera.rate,
        'images': list(camera.images),
        'shows': camera.shows,
    }
    return {key: value for key, value in plain.items() if value is not None}


def camera_of(camera: CameraDescription) -> DepthRenderCamera:
    """Return the camera for ``QueryObject.render_images``; RuntimeError for an empty range."""
    near, far = camera.range
    name, _ = RENDERERS[camera.shows]
    core = RenderCameraCore(name, camera.intrinsics, ClippingRange(near, far))
    return DepthRenderCamera(core, DepthRange(near, far))


def add_renderers(scene_graph: SceneGraph) -> None:
    """Add the renderers that cameras of scene files use, unless they exist already.

    Geometry without a label of its own is numbered, so that labels identify each geometry.
    """
    for name, role in RENDERERS.values():
        if not scene_graph.HasRenderer(name):
            params = RenderEngineExactParams(
                role=role, number_geometries=True, default_diffuse=None
            )
            scene_graph.AddRenderer(name, MakeRenderEngineExact(params))


def _intrinsics(plain: Mapping[str, Any]) -> CameraInfo:
    if 'intrinsics' in plain:
        return CameraInfo(*plain['size'], *map(float, plain['intrinsics']))
    return CameraInfo(*plain['size'], plain.get('fov_y', DEFAULT_FOV_Y))
