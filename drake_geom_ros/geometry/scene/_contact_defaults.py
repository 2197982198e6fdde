"""Contexts that give geometries the defaults of the scene's config, and those that cannot."""

from __future__ import annotations

from dataclasses import replace

from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model.contact_defaults import HeldConfig
from drake_geom_ros.geometry.model.properties import Role
from drake_geom_ros.geometry.model.scene_graph_config import SceneGraphConfig


def with_defaults(model: Model) -> None:
    """Give all geometries of a model, and those it gets, what its config has and they lack.

    Nothing where the compliance type is 'undefined'. Raises GeometryError where a geometry cannot
    be what the defaults say.
    """
    model.config = replace(model.config, gives=True, is_shared=False)
    if model.config.is_empty:
        return
    for id, record in list(model.geometries.items()):
        model.geometries[id] = record.filled(model.config)
        _ = model.geometries[id].hydroelastic_body
    model.changed(roles=[Role.kProximity], names=False)


def share(model: Model) -> None:
    """Note that a context shares a model; raises GeometryError where it has defaults to give."""
    _check_sharing(replace(model.config, is_shared=True), 'CreateSharedContext')
    model.config = replace(model.config, is_shared=True)


def configure(model: Model, config: SceneGraphConfig) -> None:
    """Give a model a config; a change of it is one of the model."""
    if config == model.config.config:
        return
    new = replace(model.config, config=config)
    _check_sharing(new, 'set_config')
    model.config = new
    model.changed(names=False)


def _check_sharing(config: HeldConfig, call: str) -> None:
    """Raise GeometryError where a config would change geometries that others share."""
    if config.is_shared and not config.is_empty:
        raise GeometryError(
            f'{call}: the config has a default compliance type, which would change '
            'geometries that a context shares; give them hydroelastic properties of their own'
        )
