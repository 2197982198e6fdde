"""Part of ``SceneGraph`` with its settings."""

from __future__ import annotations

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.model.scene_content import SceneHolder, content_of
from drake_geom_ros.geometry.model.scene_graph_config import SceneGraphConfig, checked_config
from drake_geom_ros.geometry.queries.context import SceneGraphContext
from drake_geom_ros.geometry.scene._contact_defaults import configure


class Configured(SceneHolder):
    """A scene graph with settings."""

    def get_config(self, context: SceneGraphContext | None = None) -> SceneGraphConfig:
        """Return a copy of the settings, or of those that a context was made with."""
        if context is not None:
            checked_type(context, SceneGraphContext, 'get_config: context')
        return checked_config(content_of(context or self).model.config.config)

    def set_config(self, config: SceneGraphConfig) -> None:
        """Set the default contact properties of geometries in later contexts.

        Geometries that lack them get them, also those that are registered in such a context or get
        the proximity role there. There are no defaults if their compliance type is 'undefined'. A
        change of the settings changes ``model_version()``. Raises RuntimeError for a value that a
        property cannot have, and for a compliance type if ``CreateSharedContext`` was called.
        """
        configure(self._state.model, checked_config(config))
