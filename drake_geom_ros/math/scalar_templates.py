"""Class templates as in pydrake: ``SceneGraph_[float]`` is ``SceneGraph``."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

_T = TypeVar('_T')


class ScalarTemplate(Generic[_T]):
    """A class template with an instantiation for ``float``, and others that were added.

    ``drake_geom_ros.autodiffutils`` adds those for its AutoDiffXd; pydrake's AutoDiffXd selects
    them, too.

    >>> from drake_geom_ros.math import RigidTransform, RigidTransform_
    >>> RigidTransform_[float] is RigidTransform
    True
    """

    def __init__(self, instantiation: type[_T], parameters: int = 1) -> None:
        """Make a template with a class for floats; all ``parameters`` must be the same type."""
        self._name = f'{instantiation.__name__}_'
        self._parameters = parameters
        self._instantiations: dict[str, Any] = {'float': instantiation}

    def add(self, scalar: type, instantiation: type) -> None:
        """Add the instantiation for a scalar type."""
        self._instantiations[scalar.__name__] = instantiation

    def __getitem__(self, scalar: Any) -> type[_T]:
        """Return the class for a scalar type; raises RuntimeError for an unknown one."""
        types = scalar if isinstance(scalar, tuple) else (scalar,)
        single = types[0] if types and types == self._parameters * types[:1] else None
        name = getattr(single, '__name__', '')
        # By name, so that pydrake's AutoDiffXd works without an import of pydrake.
        home = getattr(single, '__module__', '').partition('.')[0]
        is_scalar = single is float or (name != 'float' and home in ('drake_geom_ros', 'pydrake'))
        if not is_scalar or name not in self._instantiations:
            each = (', '.join(self._parameters * [other]) for other in self._instantiations)
            there = ', '.join(f'{self!r}[{parameters}]' for parameters in each)
            raise RuntimeError(f'{self!r} was asked for {scalar!r}; there is {there} only')
        instantiation: type[_T] = self._instantiations[name]
        return instantiation

    def __repr__(self) -> str:
        return self._name
