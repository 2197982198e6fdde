"""Poses and rotations, with the public names of ``pydrake.math`` that geometry needs."""

from drake_geom_ros.math.rigid_transform import RigidTransform
from drake_geom_ros.math.rotations import RollPitchYaw, RotationMatrix

__all__ = ['RigidTransform', 'RotationMatrix', 'RollPitchYaw']
