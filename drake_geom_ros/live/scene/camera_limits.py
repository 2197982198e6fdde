"""Limits of cameras that a node can publish: length of names, size of images."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drake_geom_ros.scene_files import CameraDescription

# RMW_TOPIC_MAX_NAME_LENGTH of rmw/validate_full_topic_name.h: the middleware puts a prefix before.
LONGEST_TOPIC = 247
# Bytes of a pixel while an image is made: four channels of colour, float32, int16.
_BYTES = {'color': 4, 'depth': 4, 'label': 2}
_LONGEST_END = '/cameras//depth/image_rect_raw'  # around the name of a camera


def megabytes(camera: CameraDescription, images: tuple[str, ...] = ()) -> float:
    """Return how much some images of a camera take [MB]; all that it has where none are named."""
    pixels = camera.intrinsics.width() * camera.intrinsics.height()
    return pixels * sum(_BYTES[kind] for kind in images or camera.images) / 1e6


@dataclass
class CameraLimits:
    """The most that a camera may be; without a node there is no limit."""

    megabytes: float = math.inf  # of one set of images
    name: float = math.inf  # letters

    def of_node(self, full_name: str) -> None:
        """Let names be as long as the topics of a node of that name allow."""
        self.name = LONGEST_TOPIC - len(full_name) - len(_LONGEST_END)

    def refusal(self, camera: CameraDescription) -> str:
        """Return why a camera cannot be, or an empty text."""
        if len(camera.name) > self.name:
            return (
                f'the camera name {camera.name[:40]!r}... has {len(camera.name)} letters; '
                f'{self.name} are the most: its topics would have longer names than the '
                'middleware takes'
            )
        return self.refusal_of_images(camera)

    def refusal_of_images(self, camera: CameraDescription, images: tuple[str, ...] = ()) -> str:
        """Return why some images of a camera cannot be taken, or an empty text."""
        size = megabytes(camera, images)
        if size <= self.megabytes:
            return ''
        k = camera.intrinsics
        return (
            f'images of {k.width()} x {k.height()} take {size:.1f} MB; the parameter '
            f'max_answer_size allows {self.megabytes:g} MB'
        )
