"""Placeholder state of a default ``QueryObject``, which belongs to no scene."""

from __future__ import annotations

from typing import Any, cast

from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.queries.context_state import ContextState


class _NoScene:
    """State without a scene: every attribute raises GeometryError."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith('__'):
            raise AttributeError(name)
        raise GeometryError(
            'A default QueryObject was asked a query, and it belongs to no scene: take one '
            'from scene_graph.get_query_output_port().Eval(context).'
        )


NO_SCENE = cast(ContextState, _NoScene())
