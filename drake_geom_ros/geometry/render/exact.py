"""The renderer that needs no graphics library: closed forms of rays, in compiled code."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.properties import Role
from drake_geom_ros.geometry.render.cameras import DepthRange, RenderCameraCore
from drake_geom_ros.geometry.render.render_engine import RenderedImages, RenderEngine
from drake_geom_ros.geometry.render.render_label import RenderLabel
from drake_geom_ros.geometry.rgba import Rgba
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensors import ImageDepth32F, ImageLabel16I, ImageRgba8U

if TYPE_CHECKING:
    from drake_geom_ros.geometry.render._packing import Packed, PlacedBodies

_MOST_SAMPLES = 8  # along each side of a pixel


@dataclass(frozen=True)
class RenderEngineExactParams:
    """How an exact renderer shows a scene.

    - ``default_label``: of geometry without ('label', 'id'); kUnspecified refuses such geometry.
    - ``number_geometries``: geometry without a label gets one instead, the lowest that is free,
      in the order of ids; ``QueryObject.render_legend`` tells them.
    - ``default_diffuse``: the colour of what names none; None gives each frame a colour.
    - ``default_clear_color``: that of nothing.
    - ``color_samples``: samples along each side of a pixel of colour images, from 1 to 8; depth
      and label are those of the pixel's middle.
    - ``edges``: draw edges dark.
    - ``role``: which geometry is seen; with kProximity that which distances are measured of.
    """

    default_label: RenderLabel = RenderLabel.kDontCare
    number_geometries: bool = False
    default_diffuse: Rgba | None = field(default_factory=lambda: Rgba(0.9, 0.7, 0.2))
    default_clear_color: Rgba = field(default_factory=lambda: Rgba(0.8, 0.9, 1.0))
    color_samples: int = 1
    edges: bool = True
    role: Role = Role.kPerception

    def __post_init__(self) -> None:
        if self.default_label not in (RenderLabel.kDontCare, RenderLabel.kUnspecified):
            raise ArgumentError(
                f'RenderEngineExactParams: default_label = {self.default_label!r} must be '
                'kDontCare or kUnspecified'
            )
        if self.color_samples not in range(1, _MOST_SAMPLES + 1):
            raise ArgumentError(
                f'RenderEngineExactParams: color_samples = {self.color_samples!r} must be from 1 '
                f'to {_MOST_SAMPLES}'
            )
        if self.role not in (Role.kPerception, Role.kIllustration, Role.kProximity):
            raise ArgumentError(f'RenderEngineExactParams: role = {self.role!r} must be a role')


def MakeRenderEngineExact(params: RenderEngineExactParams | None = None) -> RenderEngineExact:
    """Return a renderer that computes every pixel's ray; it needs no graphics library."""
    return RenderEngineExact(params or RenderEngineExactParams())


class RenderEngineExact(RenderEngine):
    """Shows each pixel the nearest surface along its ray, to rounding.

    Primitives are met by the closed form of a ray, meshes by their own triangles, from both sides:
    a camera within a body sees it from inside. Colours are opaque, lit from the camera and from
    above. Images of the same scene are the same to the last bit.
    """

    def __init__(self, params: RenderEngineExactParams) -> None:
        self._params = params

    def parameters(self) -> RenderEngineExactParams:
        """Return what the engine was made with."""
        return self._params

    def default_render_label(self) -> RenderLabel:
        """Return the label of geometry that has none of its own."""
        return self._params.default_label

    def _shown(self) -> RenderEngineExactParams:
        return self._params

    def _render(
        self,
        packed: Packed,
        bodies: PlacedBodies,
        core: RenderCameraCore,
        X_WS: RigidTransform,
        depth_range: DepthRange | None,
        want: frozenset[str],
    ) -> RenderedImages:
        """Return the images whose names are in ``want``."""
        # Only here: who makes no images imports nothing that does.
        from drake_geom_ros.geometry._rendering.drawing import (
            Lens,
            Look,
            Wanted,
            bytes_of,
            render,
        )

        R_SW = X_WS.rotation().matrix().T
        intrinsics, clipping = core.intrinsics(), core.clipping()
        near, far = clipping.near(), clipping.far()
        depths = (near, far)
        if depth_range is not None:
            depths = depth_range.min_depth(), depth_range.max_depth()
        lens = Lens(
            intrinsics.width(),
            intrinsics.height(),
            (intrinsics.focal_x(), intrinsics.focal_y()),
            (intrinsics.center_x(), intrinsics.center_y()),
            (near, far),
            depths,
            R_SW[:, 2],
        )
        params = self._params
        look = Look(params.default_clear_color.rgba[:3], params.edges, params.color_samples)
        images = render(
            packed.bodies,
            bodies.placed,
            R_SW @ bodies.R_WGs,
            (bodies.p_WGs - X_WS.translation()) @ R_SW.T,
            lens,
            look,
            Wanted(*(name in want for name in Wanted._fields)),
            int(RenderLabel.kEmpty),
        )
        return RenderedImages(
            ImageRgba8U.of(bytes_of(images.color)) if 'color' in want else None,
            ImageDepth32F.of(images.depth) if 'depth' in want else None,
            ImageLabel16I.of(images.label) if 'label' in want else None,
        )
