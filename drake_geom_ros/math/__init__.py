"""Poses and rotations, with the public names of ``pydrake.math`` that geometry needs."""

from typing import TYPE_CHECKING

from drake_geom_ros.math.missing import refuse_missing
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

if not TYPE_CHECKING:  # mypy would take any name for one that is there
    __getattr__ = refuse_missing(__name__)
