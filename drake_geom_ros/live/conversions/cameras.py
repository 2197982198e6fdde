"""Cameras, images and legends as messages."""

from __future__ import annotations

import array
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import FrameId, GeometryId
from drake_geom_ros.live.conversions.fields import (
    fill_pose,
    floats,
    int32s,
    pose_from_message,
    uint8s,
    unsigned,
)
from drake_geom_ros.live.conversions.message_types import CameraMessage
from drake_geom_ros.live.conversions.names import NameTable
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import (
    FAR,
    IMAGES,
    NEAR,
    PERCEPTION,
    RATE,
    CameraDescription,
    check_camera,
)
from drake_geom_ros.sensors import CameraInfo

# sensor_msgs/Image: encoding, and bytes of a pixel.
_ENCODINGS = {'color': ('rgb8', 3), 'depth': ('32FC1', 4), 'label': ('16SC1', 2)}
# In ROS, as in OpenCV, the middle of pixel u is at u, in Drake's convention at u + 0.5.
_HALF_PIXEL = 0.5


def camera_from_message(message: CameraMessage, name: str) -> CameraDescription:
    """Return the camera of a Camera message, without its frame; RuntimeError for what is none."""
    focal = list(message.intrinsics) or ([message.fov_y] if message.fov_y else [])
    p, q = message.pose.position, message.pose.orientation
    nowhere = not any((p.x, p.y, p.z, q.x, q.y, q.z, q.w))
    images = tuple(dict.fromkeys(message.images)) or IMAGES
    camera = CameraDescription(
        name,
        '',
        '',
        RigidTransform() if nowhere else pose_from_message(message.pose),
        CameraInfo(message.width, message.height, *focal),
        (message.near or NEAR, message.far or FAR),
        message.rate or RATE,
        images,
        message.shows or PERCEPTION,
    )
    check_camera(camera)
    return camera


def fill_camera(message: Any, frame: FrameId, camera: CameraDescription, names: NameTable) -> None:
    """Fill a Camera message."""
    k = camera.intrinsics
    message.name, message.frame = camera.name, names.frame_names[frame]
    fill_pose(message.pose, camera.X_FC)
    message.width, message.height = k.width(), k.height()
    intrinsics = k.focal_x(), k.focal_y(), k.center_x(), k.center_y()
    message.intrinsics = floats(np.array(intrinsics))
    message.near, message.far = map(float, camera.range)
    message.rate = float(camera.rate)
    message.images, message.shows = list(camera.images), camera.shows


def optical_frame(camera: CameraDescription) -> str:
    """Return the name of a camera's optical frame (REP 103)."""
    return f'{camera.name}_optical_frame'


def fill_header(message: Any, camera: CameraDescription, stamp: Any) -> None:
    """Say whose image it is, and of when; None as stamp: no pose has come."""
    message.header.frame_id = optical_frame(camera)
    if stamp is not None:
        message.header.stamp = stamp


def fill_camera_info(message: Any, camera: CameraDescription) -> None:
    """Fill a CameraInfo: a pinhole without distortion, the principal point in ROS's convention."""
    k = camera.intrinsics
    message.width, message.height = k.width(), k.height()
    K = k.intrinsic_matrix()
    K[:2, 2] -= _HALF_PIXEL
    message.distortion_model = 'plumb_bob'
    message.d = [0.0] * 5
    message.k = K.ravel().tolist()
    message.r = np.eye(3).ravel().tolist()
    message.p = np.column_stack((K, np.zeros(3))).ravel().tolist()


def fill_image(message: Any, kind: str, pixels: NDArray[Any]) -> None:
    """Fill an Image of a kind: 'color', 'depth' or 'label', (rows, columns, channels).

    Colours are written into the room that the message has, where it has as much as they need.
    """
    encoding, size = _ENCODINGS[kind]
    message.height, message.width = pixels.shape[:2]
    message.encoding, message.is_bigendian = encoding, 0
    message.step = size * message.width
    if kind == 'color':
        message.data = _rgb(pixels, message.data)
    else:
        message.data = uint8s(_little_endian(pixels))


def _rgb(pixels: NDArray[Any], data: array.array[int]) -> array.array[int]:
    """Return the bytes of red, green and blue of pixels (rows, columns, 4), in ``data`` or new."""
    rows, columns = pixels.shape[:2]
    if len(data) != 3 * rows * columns:
        data = array.array('B', b'\0') * (3 * rows * columns)
    packed = np.frombuffer(data, np.uint8).reshape(rows, columns, 3)
    # One channel after the other, in place: three times as fast as a copy of all three.
    for channel in range(3):
        packed[..., channel] = pixels[..., channel]
    return data


def _little_endian(pixels: NDArray[Any]) -> NDArray[np.uint8]:
    little = pixels.astype(pixels.dtype.newbyteorder('<'), copy=False)
    return np.ascontiguousarray(little).reshape(-1).view(np.uint8)


def fill_legend(message: Any, legend: dict[GeometryId, int], names: NameTable) -> None:
    """Fill a LabelLegend."""
    entries: Iterable[tuple[GeometryId, int]] = legend.items()
    shown = [(g, label) for g, label in entries if g in names.geometry_names]
    message.labels = int32s(np.array([label for _, label in shown]))
    message.ids = unsigned(np.array([g.get_value() for g, _ in shown]))
    message.geometries = [names.geometry_names[g] for g, _ in shown]
