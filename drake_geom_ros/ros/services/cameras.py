"""Services about cameras. RuntimeError refuses."""

from __future__ import annotations

from typing import Any

from drake_geom_msgs.msg import Camera

from drake_geom_ros.geometry import ArgumentError, FrameId
from drake_geom_ros.live.conversions.cameras import (
    camera_from_message,
    fill_camera,
    fill_camera_info,
    fill_header,
    fill_image,
    fill_legend,
)
from drake_geom_ros.live.conversions.message_types import CameraMessage
from drake_geom_ros.live.conversions.names import NameTable
from drake_geom_ros.live.conversions.request_types import (
    AddCameraRequest,
    EmptyRequest,
    NamedRequest,
    RenderImageRequest,
)
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.scene_files import IMAGES, camera_of


def add_camera(live: LiveScene, request: AddCameraRequest, response: Any) -> None:
    """Add a camera."""
    message = request.camera
    with live.editing() as scene:
        frame = _frame(scene.model.names, message)
        scene.cameras.add(frame, camera_from_message(message, message.name))


def remove_camera(live: LiveScene, request: NamedRequest, response: Any) -> None:
    """Remove a camera; its topics go when images are next due."""
    with live.editing() as scene:
        scene.cameras.remove(request.name)


def list_cameras(live: LiveScene, request: EmptyRequest, response: Any) -> None:
    """Report the cameras by name."""
    with live.reading() as scene:
        cameras, names = scene.cameras.by_name(), scene.model.names
    for name in sorted(cameras):
        response.cameras.append(Camera())
        fill_camera(response.cameras[-1], *cameras[name], names)


def render_image(live: LiveScene, request: RenderImageRequest, response: Any) -> None:
    """Take images of a camera, for poses that are assumed or for the live state."""
    view = live.view(request.poses, request.joints)
    if request.camera:
        with live.reading() as scene:
            frame, camera = scene.cameras.get(request.camera)
    else:
        requested = camera_from_message(request.given, 'given')
        frame, camera = _frame(view.names, request.given), requested
    want = tuple(dict.fromkeys(request.images)) or camera.images
    if unknown := [kind for kind in want if kind not in IMAGES]:
        raise ArgumentError(f'images holds {unknown[:5]}; it must be of {list(IMAGES)}')
    with live.reading() as scene:
        if reason := scene.cameras.limits.refusal_of_images(camera, want):
            raise ArgumentError(reason)
    images = view.query.render_images(camera_of(camera), frame, camera.X_FC, want)
    stamp = view.moment.newest_stamp
    for kind in want:
        message = getattr(response, kind)
        fill_image(message, kind, getattr(images, kind).data)
        fill_header(message, camera, stamp)
    fill_camera_info(response.camera_info, camera)
    renderer = camera_of(camera).core().renderer_name()
    fill_legend(response.legend, view.query.render_legend(renderer), view.names)
    response.legend.scene_version = view.moment.version
    for message in (response.camera_info, response.legend):
        fill_header(message, camera, stamp)
    response.waiting_frames = view.waiting().frames
    response.message = view.reservations()


def _frame(names: NameTable, message: CameraMessage) -> FrameId:
    """Return the frame that a Camera message names; empty: the world."""
    return names.frame(message.frame) if message.frame else names.world
