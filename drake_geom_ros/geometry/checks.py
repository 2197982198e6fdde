"""Checks of arguments: types, canonical names, numbers and poses."""

from __future__ import annotations

import math
from numbers import Real
from typing import Any, TypeVar

import numpy as np

from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.tolerances import FARTHEST

_T = TypeVar('_T')


def canonical_name(name: str, what: str) -> str:
    """Return the name without surrounding spaces and tabs; RuntimeError if empty or with NUL.

    A string of a ROS message ends at its first NUL: names that differ after it would be equal.
    """
    trimmed = checked_type(name, str, f'{what}: name').strip(' \t')
    if not trimmed:
        raise ArgumentError(f'{what}: the name {name!r} is empty once trimmed of spaces and tabs')
    if '\0' in trimmed:
        raise ArgumentError(f'{what}: the name {name!r} holds a NUL character')
    return trimmed


def checked_type(value: Any, kind: type[_T], what: str) -> _T:
    """Return the value; raises RuntimeError (also a TypeError) if it is of another kind."""
    if not isinstance(value, kind):
        raise ArgumentTypeError(f'{what} = {value!r} must be of type {kind.__name__}')
    return value


def as_number(value: object) -> float | None:
    """Return a number, also one of NumPy, as a float; None for other values, such as a bool.

    A number too large for a float becomes infinite.
    """
    if isinstance(value, bool) or not isinstance(value, Real):  # np.bool is no Real
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf  # type: ignore[operator]


def checked_pose(X: RigidTransform, what: str) -> RigidTransform:
    """Return a copy of the pose; raises an error for one beyond FARTHEST."""
    pose = RigidTransform(checked_type(X, RigidTransform, what))
    if (np.abs(pose.translation()) > FARTHEST).any():
        raise ArgumentError(
            f'{what} lies at {pose.translation().tolist()} m; no coordinate may be beyond '
            f'{FARTHEST:.3g} m'
        )
    return pose


def checked_budget(seconds: float | None) -> float:
    """Return a time budget [s], 0 where there is none; ArgumentError for one that cannot be."""
    if seconds is None:
        return 0.0
    if not seconds >= 0.0:
        raise ArgumentError(
            f'time_budget={seconds} was asked for; it must be seconds >= 0, and 0 or None is no '
            'limit.'
        )
    return float(seconds)
