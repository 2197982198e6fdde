"""``RenderEngine``: the base class of renderers."""

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
    """Images of one moment and one camera; None for those not requested."""

    color: ImageRgba8U | None
    depth: ImageDepth32F | None
    label: ImageLabel16I | None


class CameraShot(NamedTuple):
    """A camera whose sensor is posed at X_WS, with the images that are wanted of it."""

    core: RenderCameraCore
    X_WS: RigidTransform
    depth_range: DepthRange | None
    want: frozenset[str]

    def visible_depths(self) -> tuple[float, float]:
        """Return the smallest and the largest depth [m] of its depth image."""
        if self.depth_range is not None:
            return self.depth_range.min_depth(), self.depth_range.max_depth()
        clipping = self.core.clipping()
        return clipping.near(), clipping.far()


class RenderEngine(ABC):
    """Renderer of the geometry with the perception role, which a scene graph stores by name.

    ``MakeRenderEngineExact`` and ``MakeRenderEngineVtk`` make one. It is immutable, so scenes and
    contexts share it.
    """

    def Clone(self) -> RenderEngine:
        """Return this engine, since it is immutable."""
        return self

    @abstractmethod
    def default_render_label(self) -> RenderLabel:
        """Return the default label of geometry."""

    @abstractmethod
    def _shown(self) -> RenderEngineExactParams:
        """Return the parameters that select, label and colour the geometry."""

    @abstractmethod
    def _render(self, packed: Packed, bodies: PlacedBodies, shot: CameraShot) -> RenderedImages:
        """Return the images that a shot wants."""


def shown_by(engine: RenderEngine) -> RenderEngineExactParams:
    """Return the parameters by which an engine selects, labels and colours geometry."""
    return engine._shown()


def images_of(
    engine: RenderEngine, packed: Packed, bodies: PlacedBodies, shot: CameraShot
) -> RenderedImages:
    """Return the images that a shot wants, made by an engine."""
    return engine._render(packed, bodies, shot)
