"""The templates of pydrake: ``SceneGraph_[float]`` is ``SceneGraph``."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

_T = TypeVar('_T')


class ScalarTemplate(Generic[_T]):
    """A class by its scalar type, as pydrake names it: for ``float``, and for what was added.

    ``drake_geom_ros.autodiffutils`` adds classes for its AutoDiffXd, which pydrake's stands for,
    too.

    >>> from drake_geom_ros.math import RigidTransform, RigidTransform_
    >>> RigidTransform_[float] is RigidTransform
    True
    """

    def __init__(self, instantiation: type[_T], parameters: int = 1) -> None:
        """Have a class for floats; all of its ``parameters`` are the same scalar type."""
        self._name = f'{instantiation.__name__}_'
        self._parameters = parameters
        self._instantiations: dict[str, Any] = {'float': instantiation}

    def add(self, scalar: type, instantiation: type) -> None:
        """Make a class the one for a scalar type."""
        self._instantiations[scalar.__name__] = instantiation

    def __getitem__(self, scalar: Any) -> type[_T]:
        """Return the class for a scalar type; raises RuntimeError for one that there is not."""
        given = scalar if isinstance(scalar, tuple) else (scalar,)
        asked = given[0] if given and given == self._parameters * given[:1] else None
        name = getattr(asked, '__name__', '')
        # By name, for pydrake's AutoDiffXd is known without pydrake.
        home = getattr(asked, '__module__', '').partition('.')[0]
        known = asked is float or (name != 'float' and home in ('drake_geom_ros', 'pydrake'))
        if not known or name not in self._instantiations:
            each = (', '.join(self._parameters * [known]) for known in self._instantiations)
            there = ', '.join(f'{self!r}[{parameters}]' for parameters in each)
            raise RuntimeError(f'{self!r} was asked for {scalar!r}; there is {there} only')
        found: type[_T] = self._instantiations[name]
        return found

    def __repr__(self) -> str:
        return self._name
