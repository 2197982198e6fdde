"""Roles of geometries, and the properties for each role."""

from __future__ import annotations

import copy
import enum
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.common.value import AbstractValue
from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError, GeometryError
from drake_geom_ros.geometry.model.rgba import Rgba

_P = TypeVar('_P', bound='GeometryProperties')
_DEFAULT_GROUP = '__default__'


class _PydrakeEnum(enum.Enum):
    """An enumeration that prints as pydrake's and has ``int()``."""

    def __int__(self) -> int:
        return int(self.value)


class Role(_PydrakeEnum):
    """The purpose of a geometry, with pydrake's numbers."""

    kUnassigned = 0
    kProximity = 1
    kIllustration = 2
    kPerception = 4


class RoleAssign(_PydrakeEnum):
    """Mode of ``AssignRole``: a new role, or new properties of an existing one."""

    kNew = 0
    kReplace = 1


class GeometryProperties:
    """Values by group and name: the base of the properties of each role.

    It is empty, or a copy of the properties of any role. Values are copied in and copied out. The
    type of a value is fixed when it is added. Properties from a scene are read-only: assign
    changed copies with ``AssignRole`` and ``RoleAssign.kReplace``.

        >>> properties = ProximityProperties()
        >>> properties.AddProperty('material', 'friction', 0.5)
        >>> properties.GetPropertyOrDefault('material', 'friction', 1.0)
        0.5
    """

    __slots__ = ('_groups', '_read_only')

    def __init__(self, other: GeometryProperties | None = None) -> None:
        if type(self) is GeometryProperties:
            raise ArgumentTypeError('GeometryProperties: make those of a role')
        if other is not None and not isinstance(other, GeometryProperties):
            raise ArgumentTypeError(f'{type(self).__name__}: cannot copy {other!r}')
        groups = {_DEFAULT_GROUP: {}} if other is None else copy.deepcopy(other._groups)
        self._groups: dict[str, dict[str, Any]] = groups
        self._read_only = False

    @staticmethod
    def default_group_name() -> str:
        """Return the name of the group that always exists."""
        return _DEFAULT_GROUP

    def HasGroup(self, group_name: str) -> bool:
        """Return whether the group exists."""
        return group_name in self._groups

    def num_groups(self) -> int:
        """Return the number of groups, the default group included."""
        return len(self._groups)

    def GetGroupNames(self) -> set[str]:
        """Return the names of all groups."""
        return set(self._groups)

    def GetPropertiesInGroup(self, group_name: str) -> dict[str, AbstractValue]:
        """Return names and values of a group, each as an ``AbstractValue`` with ``get_value()``.

        Raises RuntimeError if the group does not exist.
        """
        if group_name not in self._groups:
            raise ArgumentError(
                f'GetPropertiesInGroup: no group {group_name!r}; there are {list(self._groups)}'
            )
        group = self._groups[group_name]
        return {name: AbstractValue.Make(value) for name, value in group.items()}

    def HasProperty(self, group_name: str, name: str) -> bool:
        """Return whether the group and the property in it exist."""
        return name in self._groups.get(group_name, {})

    def GetProperty(self, group_name: str, name: str) -> Any:
        """Return the value; raises RuntimeError if there is no such property."""
        if not self.HasProperty(group_name, name):
            group = self._groups.get(group_name)
            existing = f'groups {list(self._groups)}' if group is None else f'names {list(group)}'
            raise ArgumentError(
                f'GetProperty: there is no property ({group_name!r}, {name!r}); {existing} exist'
            )
        return copy.deepcopy(self._groups[group_name][name])

    def GetPropertyOrDefault(self, group_name: str, name: str, default_value: Any) -> Any:
        """Return the value, or ``default_value`` if there is no such property.

        Raises RuntimeError if the value is of another type than the default (unless that is
        None).
        """
        if not self.HasProperty(group_name, name):
            return default_value
        value = self.GetProperty(group_name, name)
        if default_value is not None:
            _check_same_type('GetPropertyOrDefault', group_name, name, value, default_value)
        return value

    def AddProperty(self, group_name: str, name: str, value: Any) -> None:
        """Add a property, and its group if necessary; raises RuntimeError if it exists."""
        if self.HasProperty(group_name, name):
            raise ArgumentError(
                f'AddProperty: the property ({group_name!r}, {name!r}) exists already; '
                'see UpdateProperty'
            )
        self.UpdateProperty(group_name, name, value)

    def UpdateProperty(self, group_name: str, name: str, value: Any) -> None:
        """Add a property, or replace its value; raises RuntimeError for another type."""
        self._check_writable()
        if not isinstance(group_name, str) or not isinstance(name, str):
            raise ArgumentTypeError(f'property ({group_name!r}, {name!r}): names must be str')
        stored = value.item() if isinstance(value, np.generic) else copy.deepcopy(value)
        if self.HasProperty(group_name, name):
            old = self._groups[group_name][name]
            _check_same_type('UpdateProperty', group_name, name, old, stored)
        self._groups.setdefault(group_name, {})[name] = stored

    def RemoveProperty(self, group_name: str, name: str) -> bool:
        """Remove a property, and return whether it existed; its group stays."""
        self._check_writable()
        existed = self.HasProperty(group_name, name)
        if existed:
            del self._groups[group_name][name]
        return existed

    def _check_writable(self) -> None:
        """Raise RuntimeError for properties that belong to a scene."""
        if self._read_only:
            raise GeometryError(
                f'{type(self).__name__}: these belong to a registered geometry; change a copy and '
                'assign it with AssignRole(..., RoleAssign.kReplace)'
            )

    def __copy__(self: _P) -> _P:
        return type(self)(self)

    def __deepcopy__(self: _P, memo: dict[int, Any]) -> _P:
        return type(self)(self)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return _equal(self._groups, other._groups)

    def __str__(self) -> str:
        lines = []
        for group_name, group in self._groups.items():
            lines.append(f'[{group_name}]')
            lines += [f'  {name}: {value}' for name, value in group.items()]
        return '\n'.join(lines)


class ProximityProperties(GeometryProperties):
    """The properties of a geometry that takes part in proximity queries."""

    __slots__ = ()


class IllustrationProperties(GeometryProperties):
    """The properties of a geometry that is drawn."""

    __slots__ = ()


class PerceptionProperties(GeometryProperties):
    """The properties of a geometry that sensors see."""

    __slots__ = ()


def MakePhongIllustrationProperties(diffuse: ArrayLike) -> IllustrationProperties:
    """Return properties whose ``('phong', 'diffuse')`` is the colour r, g, b, a, (4,)."""
    values = np.asarray(diffuse, dtype=np.float64)
    if values.shape != (4,):
        raise ArgumentError(
            f'MakePhongIllustrationProperties: diffuse = {values.tolist()} must be r, g, b, a'
        )
    properties = IllustrationProperties()
    properties.AddProperty('phong', 'diffuse', Rgba(*values.tolist()))
    return properties


def frozen(properties: _P) -> _P:
    """Return a read-only copy, which a scene can share with its contexts."""
    copy = type(properties)(properties)
    copy._read_only = True
    return copy


def _equal(a: Any, b: Any) -> bool:
    """Return whether two values are of one type and equal, arrays within them included."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(_equal(value, b[key]) for key, value in a.items())
    if isinstance(a, (list, tuple)):
        return len(a) == len(b) and all(map(_equal, a, b))
    return bool(a == b)


def _check_same_type(call: str, group_name: str, name: str, old: Any, new: Any) -> None:
    """Raise RuntimeError when a property would change its type."""
    if type(old) is not type(new):
        raise ArgumentTypeError(
            f'{call}: the property ({group_name!r}, {name!r}) is of type {type(old).__name__}, '
            f'given {type(new).__name__}'
        )
