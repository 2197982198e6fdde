"""Values of SDFormat elements: texts, numbers, flags and poses, with their places."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.xml_tree import place_of

_FLAGS = {'true': True, '1': True, 'false': False, '0': False}
_UNIT_TOLERANCE = 0.01
# Behind a number, as one of Drake's models has it; libsdformat and Drake read the number.
_QUOTES = '"\''


@dataclass(frozen=True)
class SdfFile:
    """A file of SDFormat, with its version and the folder that its paths count from."""

    name: str
    folder: Path
    version: tuple[int, ...]

    def at(self, element: Any) -> Location:
        """Return the place of an element of the file."""
        return place_of(element, self.name)


def text_of(element: Any, child: str = '', default: str = '') -> str:
    """Return the text of an element, or of its first child of a name."""
    holder = element.find(child) if child else element
    return default if holder is None else (holder.text or '').strip()


def numbers_in(element: Any, child: str, count: int, default: str | None = None) -> list[float]:
    """Return the finite numbers of a child element; ValueError, which names no line, for others.

    A missing or empty child counts as ``default``; without a default it is required.
    """
    text = text_of(element, child) or default
    name = child or str(element.tag)
    if text is None:
        raise ValueError(f'<{element.tag}> has no <{child}>')
    try:
        values = [float(word) for word in text.rstrip(_QUOTES).split()]
    except ValueError:
        values = []
    if len(values) != count or '_' in text or not all(map(math.isfinite, values)):
        wanted = 'a finite number' if count == 1 else f'{count} finite numbers'
        raise ValueError(f'<{name}> is {text!r}; it must be {wanted}')
    return values


def number_in(element: Any, child: str, default: float) -> float:
    """Return a number that may be infinite; ValueError, which names no line, for others."""
    text = text_of(element, child).rstrip(_QUOTES)
    try:
        value = float(text) if text else default
    except ValueError:
        value = math.nan
    if math.isnan(value):
        raise ValueError(f'<{child}> is {text!r}; it must be a number')
    return value


def flag_in(element: Any, child: str, default: bool = False) -> bool:
    """Return a flag; ValueError, which names no line, for another text."""
    text = text_of(element, child).lower()
    if not text:
        return default
    if text not in _FLAGS:
        raise ValueError(f'<{child}> is {text!r}; it must be true or false')
    return _FLAGS[text]


def pose_in(element: Any) -> tuple[RigidTransform, str]:
    """Return the pose of an element, and the frame that it counts from, '' for the default one.

    Angles are radians, or degrees with ``degrees="true"``; with ``rotation_format="quat_xyzw"``
    there is a quaternion. Raises ValueError, which names no line, for invalid numbers.
    """
    pose = element.find('pose')
    if pose is None:
        return RigidTransform(), ''
    relative_to = pose.get('relative_to') or pose.get('frame') or ''
    kind = pose.get('rotation_format', 'euler_rpy')
    if kind not in ('euler_rpy', 'quat_xyzw'):
        raise ValueError(f'rotation_format {kind!r} must be euler_rpy or quat_xyzw')
    count = 6 if kind == 'euler_rpy' else 7
    values = numbers_in(element, 'pose', count, ' '.join('0' * (count - 1)) + f' {count - 6}')
    if count == 7:
        length = math.hypot(*values[3:])
        if not abs(length - 1.0) <= _UNIT_TOLERANCE:
            raise ValueError(f'<pose> is {text_of(pose)!r}; its quaternion must be of unit length')
        return RigidTransform.FromArray(
            [*values[:3], *(q / length for q in values[3:])]
        ), relative_to
    in_degrees = pose.get('degrees', 'false').lower() in ('true', '1')
    rpy = [math.radians(angle) if in_degrees else angle for angle in values[3:]]
    return RigidTransform(RollPitchYaw(rpy).ToRotationMatrix(), values[:3]), relative_to
