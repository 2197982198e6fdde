"""Poses, rotations and functions of numbers, with the public names of ``pydrake.math``.

Constructors reject arrays that are no rotation or no pose.
"""

from typing import TYPE_CHECKING

from drake_geom_ros.math.missing import refuse_missing
from drake_geom_ros.math.rigid_transform import RigidTransform
from drake_geom_ros.math.rotations import RollPitchYaw, RotationMatrix
from drake_geom_ros.math.scalar_functions import (
    abs,
    acos,
    arccos,
    arcsin,
    arctan,
    arctan2,
    asin,
    atan,
    atan2,
    ceil,
    cos,
    cosh,
    exp,
    floor,
    isnan,
    log,
    max,
    min,
    pow,
    sin,
    sinh,
    sqrt,
    tan,
    tanh,
)
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
    'abs',
    'acos',
    'arccos',
    'arcsin',
    'arctan',
    'arctan2',
    'asin',
    'atan',
    'atan2',
    'ceil',
    'cos',
    'cosh',
    'exp',
    'floor',
    'isnan',
    'log',
    'max',
    'min',
    'pow',
    'sin',
    'sinh',
    'sqrt',
    'tan',
    'tanh',
]

if not TYPE_CHECKING:  # mypy would take any name for one that is there
    __getattr__ = refuse_missing(__name__)
