"""Poses and rotations, with the public names of ``pydrake.math`` that geometry needs."""

from drake_geom_ros.math.rigid_transform import RigidTransform
from drake_geom_ros.math.rotations import RollPitchYaw, RotationMatrix
from drake_geom_ros.math.scalar_templates import ScalarTemplate

RigidTransform_ = ScalarTemplate(RigidTransform)
RotationMatrix_ = ScalarTemplate(RotationMatrix)
RollPitchYaw_ = ScalarTemplate(RollPitchYaw)

__all__ = [
    'RigidTransform',
    'RotationMatrix',
    'RollPitchYaw',
    'RigidTransform_',
    'RotationMatrix_',
    'RollPitchYaw_',
    'ScalarTemplate',
]
