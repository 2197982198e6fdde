"""Images, and the intrinsics of the cameras that take them: pydrake's ``systems.sensors``.

In: sizes and numbers of cameras, arrays of pixels.
Out: checked intrinsics and images.
May import: ``math``; numpy.
"""

from drake_geom_ros.sensors.camera_info import CameraInfo
from drake_geom_ros.sensors.images import Image, ImageDepth32F, ImageLabel16I, ImageRgba8U

__all__ = ['CameraInfo', 'Image', 'ImageRgba8U', 'ImageDepth32F', 'ImageLabel16I']
