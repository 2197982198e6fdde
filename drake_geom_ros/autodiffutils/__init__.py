"""Automatic differentiation: numbers with gradients, and the names of ``pydrake.autodiffutils``.

An ``AutoDiffXd`` has a value and a gradient (n,), and arithmetic propagates both.
"""

from drake_geom_ros.autodiffutils.arrays import (
    ExtractGradient,
    ExtractValue,
    InitializeAutoDiff,
    InitializeAutoDiffTuple,
    autodiff_equal_to,
)
from drake_geom_ros.autodiffutils.autodiff import AutoDiffXd
from drake_geom_ros.autodiffutils.transforms import (
    RigidTransformAutoDiffXd,
    RollPitchYawAutoDiffXd,
    RotationMatrixAutoDiffXd,
)
from drake_geom_ros.math import RigidTransform_, RollPitchYaw_, RotationMatrix_

RigidTransform_.add(AutoDiffXd, RigidTransformAutoDiffXd)
RollPitchYaw_.add(AutoDiffXd, RollPitchYawAutoDiffXd)
RotationMatrix_.add(AutoDiffXd, RotationMatrixAutoDiffXd)

__all__ = [
    'AutoDiffXd',
    'ExtractGradient',
    'ExtractValue',
    'InitializeAutoDiff',
    'InitializeAutoDiffTuple',
    'autodiff_equal_to',
]
