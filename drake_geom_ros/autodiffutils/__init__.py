"""Numbers that carry derivatives, with the names of ``pydrake.autodiffutils``.

In: values with gradients (n,).
Out: numbers that carry both through arithmetic.
May import: ``math``; numpy.
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
