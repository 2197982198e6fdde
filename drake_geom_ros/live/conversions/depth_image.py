"""Depth images with their CameraInfo to points."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import ArgumentError

# sensor_msgs/Image: its encoding, how a pixel is written, and its unit [m] (REP 118).
_MOST_COEFFICIENTS = 100  # no model of a lens has as many
_ENCODINGS = {'16UC1': ('u2', 1.0 / 1000.0), '32FC1': ('f4', 1.0)}


def points_from_depth(image: Any, camera: Any) -> NDArray[np.float64]:
    """Return the points (n, 3) [m] that a depth image shows, in its optical frame (z ahead).

    Of a pixel that shows nothing (0, or not finite) the point is not finite. ``camera`` is the
    CameraInfo of a rectified image of that size: the left of ``P`` counts, or ``K`` where lenses
    do not distort. Raises ArgumentError for other encodings, for less or more data than the image
    says, and for a camera that is none or of another image.
    """
    if image.encoding not in _ENCODINGS:
        raise ArgumentError(
            f'encoding is {image.encoding[:80]!r}; depth images are {" or ".join(_ENCODINGS)}'
        )
    kind, unit = _ENCODINGS[image.encoding]
    width, height = image.width, image.height
    size = np.dtype(kind).itemsize
    needed = image.step * (height - 1) + width * size if width and height else 0
    if image.step < width * size or len(image.data) < needed:
        raise ArgumentError(
            f'data holds {len(image.data)} bytes; {height} rows of {width} pixels of {size} bytes '
            f'with step {image.step} do not fit in it'
        )
    if len(image.data) > height * image.step:
        raise ArgumentError(
            f'data holds {len(image.data)} bytes; {height} rows with step {image.step} have '
            f'{height * image.step}; it may hold no more'
        )
    focal_x, focal_y, center_x, center_y = _intrinsics(camera, width, height)
    if not needed:
        return np.zeros((0, 3))
    pixel = np.dtype(('>' if image.is_bigendian else '<') + kind)
    rows = np.ndarray((height, width), pixel, memoryview(image.data), strides=(image.step, size))
    with np.errstate(invalid='ignore'):
        z = rows.astype(np.float64) * unit
        z[~(z > 0.0)] = math.nan
    x = (np.arange(width) - center_x) / focal_x
    y = (np.arange(height) - center_y) / focal_y
    with np.errstate(invalid='ignore'):  # of inf, which is no point anyhow
        points = np.stack([z * x, z * y[:, np.newaxis], z], axis=2)
    return points.reshape(-1, 3)


def _intrinsics(camera: Any, width: int, height: int) -> tuple[float, float, float, float]:
    """Return focal_x, focal_y, center_x, center_y [pixels]; the middle of pixel u is at u."""
    if (camera.width, camera.height) != (width, height):
        raise ArgumentError(
            f'camera_info is of {camera.width} x {camera.height} pixels, and the image has '
            f'{width} x {height}'
        )
    region = camera.roi
    is_part = any((region.x_offset, region.y_offset, region.width, region.height))
    if max(camera.binning_x, camera.binning_y) > 1 or is_part:
        raise ArgumentError('camera_info tells of binning or a region; whole images are taken')
    if len(camera.d) > _MOST_COEFFICIENTS:
        raise ArgumentError(
            f'camera_info has {len(camera.d)} coefficients d of distortion; at most '
            f'{_MOST_COEFFICIENTS} are read'
        )
    P, K, distortion = (list(map(float, each)) for each in (camera.p, camera.k, camera.d))
    if len(P) == 12 and P[0] != 0.0:
        intrinsics = P[0], P[5], P[2], P[6]
    elif any(distortion):
        raise ArgumentError('camera_info has distortion in d and no p: the image is not rectified')
    else:
        intrinsics = K[0], K[4], K[2], K[5]
    if not all(map(math.isfinite, intrinsics)) or min(intrinsics[:2]) <= 0.0:
        raise ArgumentError(
            f'camera_info has focal lengths and a centre {intrinsics}, which are none'
        )
    return intrinsics
