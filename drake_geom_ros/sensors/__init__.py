"""Images and camera intrinsics, with the names of ``pydrake.systems.sensors``."""

from drake_geom_ros.sensors.camera_info import CameraInfo
from drake_geom_ros.sensors.images import Image, ImageDepth32F, ImageLabel16I, ImageRgba8U

__all__ = ['CameraInfo', 'Image', 'ImageRgba8U', 'ImageDepth32F', 'ImageLabel16I']
