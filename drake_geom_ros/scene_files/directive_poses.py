"""Poses in Drake's model directives, with the tags of their rotations."""

import math

from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix
from drake_geom_ros.math.quaternions import AngleAxis
from drake_geom_ros.scene_files.yaml_text import Document, KeyPath

# Keys of a rotation by its tag; those that a rotation has without a tag are these of !Rpy.
_KEYS = {'!Identity': (), '!Rpy': ('deg',), '!AngleAxis': ('angle_deg', 'axis')}
TAGS = tuple(_KEYS)


def pose_at(document: Document, *path: str | int) -> RigidTransform:
    """Return the pose at a key, the identity if it is missing.

    Raises SceneFileError for a tag at another place than the rotation, and for a rotation with
    other keys than its tag has.
    """
    plain = document.value
    for step in path:
        if isinstance(plain, dict) and step not in plain:
            return RigidTransform()
        plain = plain[step]
    for tagged in (path, (*path, 'translation')):
        if tagged in document.tags:
            tag = document.tags[tagged]
            raise document.at(*tagged).error(f'tag {tag}; the rotation alone may have one')
    translation = plain.get('translation', (0.0, 0.0, 0.0))
    return RigidTransform(_rotation(document, plain, (*path, 'rotation')), translation)


def _rotation(document: Document, plain: dict[str, object], path: KeyPath) -> RotationMatrix:
    """Return the rotation of a pose, the identity if it has none."""
    values = plain.get('rotation')
    if values is None:
        return RotationMatrix()
    assert isinstance(values, dict)
    tag = document.tags.get(path, '')
    for inner in ((*path, key) for key in values):
        if inner in document.tags:
            raise document.at(*inner).error(
                f'tag {document.tags[inner]}; only fixed numbers are read'
            )
    if not tag or values.keys() != set(_KEYS[tag]):
        raise document.at(*path).error(
            'must be !Rpy {deg: [roll, pitch, yaw]}, !AngleAxis {angle_deg: ..., axis: [x, y, z]} '
            'or !Identity {}'
        )
    if tag == '!Rpy':
        return RollPitchYaw([math.radians(a) for a in values['deg']]).ToRotationMatrix()
    if tag == '!AngleAxis':
        length = math.hypot(*values['axis'])
        if not length > 0.0:
            raise document.at(*path, 'axis').error('the axis must not be zero')
        axis = [component / length for component in values['axis']]
        return RotationMatrix(theta_lambda=AngleAxis(math.radians(values['angle_deg']), axis))
    return RotationMatrix()
