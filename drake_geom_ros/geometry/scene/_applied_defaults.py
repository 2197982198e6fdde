"""Application of the scene's default contact properties to the models of contexts."""

from __future__ import annotations

from dataclasses import replace

from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model.contact_defaults import HeldConfig
from drake_geom_ros.geometry.model.properties import Role
from drake_geom_ros.geometry.model.scene_graph_config import SceneGraphConfig


def with_defaults(model: Model) -> None:
    """Add the defaults of its config to all geometries of a model, now and later, that lack them.

    Does nothing if the compliance type is 'undefined'. Raises GeometryError if the defaults do not
    suit a geometry.
    """
    model.config = replace(model.config, gives=True, is_shared=False)
    if model.config.is_empty:
        return
    for id, record in list(model.geometries.items()):
        model.geometries[id] = record.filled(model.config)
        _ = model.geometries[id].hydroelastic_body
    model.changed_geometries(None, [Role.kProximity], names=False)


def share(model: Model) -> None:
    """Mark a model as shared with a context; raises GeometryError if it has defaults."""
    _check_sharing(replace(model.config, is_shared=True), 'CreateSharedContext')
    model.config = replace(model.config, is_shared=True)


def configure(model: Model, config: SceneGraphConfig) -> None:
    """Set the config of a model, which changes its version."""
    if config == model.config.config:
        return
    new = replace(model.config, config=config)
    _check_sharing(new, 'set_config')
    model.config = new
    model.changed(names=False)


def _check_sharing(config: HeldConfig, call: str) -> None:
    """Raise GeometryError if a config would change geometries that contexts share."""
    if config.is_shared and not config.is_empty:
        raise GeometryError(
            f'{call}: the config has a default compliance type, which would change '
            'geometries that a context shares; give them hydroelastic properties of their own'
        )
