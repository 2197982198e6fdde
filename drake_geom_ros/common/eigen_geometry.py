"""Quaternions and angle-axes, under the module name that pydrake has them in."""

from drake_geom_ros.math.quaternions import AngleAxis, Quaternion

__all__ = ['AngleAxis', 'Quaternion']
