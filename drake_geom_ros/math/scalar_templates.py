"""The templates of pydrake: ``SceneGraph_[float]`` is ``SceneGraph``."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

_T = TypeVar('_T')


class ScalarTemplate(Generic[_T]):
    """A class by its scalar type, as pydrake names it; there is one, for ``float``.

    >>> from drake_geom_ros.math import RigidTransform, RigidTransform_
    >>> RigidTransform_[float] is RigidTransform
    True
    """

    def __init__(self, instantiation: type[_T]) -> None:
        self._instantiation = instantiation

    def __getitem__(self, scalar: Any) -> type[_T]:
        """Return the class for a scalar type; raises RuntimeError for any but float."""
        if scalar not in (float, (float,)):
            raise RuntimeError(f'{self!r} was asked for {scalar!r}; there is {self!r}[float] only')
        return self._instantiation

    def __repr__(self) -> str:
        return f'{self._instantiation.__name__}_'
