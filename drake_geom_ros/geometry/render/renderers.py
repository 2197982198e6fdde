"""The renderers of a model: who may be asked for images, by name."""

from __future__ import annotations

from typing import cast

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import (
    ArgumentError,
    ArgumentTypeError,
    DuplicateError,
    GeometryError,
)
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.render.render_engine import RenderEngine


class Renderers:
    """Adds and removes renderers of a model, and finds them."""

    def __init__(self, model: Model) -> None:
        # ``add`` alone puts renderers there.
        self._named = cast(dict[str, RenderEngine], model.renderers)

    def add(self, name: str, renderer: RenderEngine) -> None:
        """Add a renderer; raises DuplicateError for a name that is taken."""
        if not checked_type(name, str, 'AddRenderer: name'):
            raise ArgumentError('AddRenderer: name must not be empty')
        if not isinstance(renderer, RenderEngine):
            raise ArgumentTypeError(f'AddRenderer: renderer = {renderer!r} must be a RenderEngine')
        if name in self._named:
            raise DuplicateError(
                f'AddRenderer: the name {name!r} is taken, of a {type(self._named[name]).__name__}'
            )
        self._named[name] = renderer

    def remove(self, name: str) -> None:
        """Remove a renderer; raises GeometryError where there is none of this name."""
        self.find(name, 'RemoveRenderer')
        del self._named[name]

    def find(self, name: str, what: str) -> RenderEngine:
        """Return the renderer of a name; raises GeometryError, naming those that there are."""
        if name not in self._named:
            known = f'there are {sorted(self._named)}' if self._named else 'there is none'
            raise GeometryError(
                f'{what}: there is no renderer {name!r}, {known}; see SceneGraph.AddRenderer'
            )
        return self._named[name]
