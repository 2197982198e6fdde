"""What all renderers are."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, NamedTuple

from drake_geom_ros.geometry.render.render_label import RenderLabel
from drake_geom_ros.sensors import ImageDepth32F, ImageLabel16I, ImageRgba8U

if TYPE_CHECKING:
    from drake_geom_ros.geometry.render._packing import Packed, PlacedBodies
    from drake_geom_ros.geometry.render.cameras import DepthRange, RenderCameraCore
    from drake_geom_ros.geometry.render.exact_params import RenderEngineExactParams
    from drake_geom_ros.math import RigidTransform


class RenderedImages(NamedTuple):
    """Images of one moment, of one camera; None what was not asked for."""

    color: ImageRgba8U | None
    depth: ImageDepth32F | None
    label: ImageLabel16I | None


class RenderEngine(ABC):
    """Makes images of the geometry with the perception role; a scene graph holds it by a name.

    Made by ``MakeRenderEngineExact`` or ``MakeRenderEngineVtk``. It never changes, so that scenes
    and contexts share it.
    """

    def Clone(self) -> RenderEngine:
        """Return an engine that does the same: this one."""
        return self

    @abstractmethod
    def default_render_label(self) -> RenderLabel:
        """Return the label of geometry that has none of its own."""

    @abstractmethod
    def _shown(self) -> RenderEngineExactParams:
        """Return what says which geometry is shown, and how it is labelled and coloured."""

    @abstractmethod
    def _render(
        self,
        packed: Packed,
        bodies: PlacedBodies,
        core: RenderCameraCore,
        X_WS: RigidTransform,
        depth_range: DepthRange | None,
        want: frozenset[str],
    ) -> RenderedImages:
        """Return the images whose names are in ``want``, of a sensor posed in World."""


def shown_by(engine: RenderEngine) -> RenderEngineExactParams:
    """Return what says which geometry an engine shows, and how it is labelled and coloured."""
    return engine._shown()


def images_of(
    engine: RenderEngine,
    packed: Packed,
    bodies: PlacedBodies,
    core: RenderCameraCore,
    X_WS: RigidTransform,
    depth_range: DepthRange | None,
    want: frozenset[str],
) -> RenderedImages:
    """Return the images whose names are in ``want``, of a sensor posed in World."""
    return engine._render(packed, bodies, core, X_WS, depth_range, want)
