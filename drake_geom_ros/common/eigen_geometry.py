"""Quaternions and angle-axes, under pydrake's module name."""

from drake_geom_ros.math.quaternions import AngleAxis, Quaternion

__all__ = ['AngleAxis', 'Quaternion']
