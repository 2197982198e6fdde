"""Registry of the renderers of a model, by name."""

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
    """Adds, removes and looks up the renderers of a model."""

    def __init__(self, model: Model) -> None:
        # Only ``add`` puts renderers there, so the type is known.
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
        """Remove a renderer; raises GeometryError if there is none of this name."""
        self.find(name, 'RemoveRenderer')
        del self._named[name]

    def find(self, name: str, what: str) -> RenderEngine:
        """Return a renderer by name; raises GeometryError with the existing names."""
        if name not in self._named:
            existing = f'there are {sorted(self._named)}' if self._named else 'there is none'
            raise GeometryError(
                f'{what}: there is no renderer {name!r}, {existing}; see SceneGraph.AddRenderer'
            )
        return self._named[name]
