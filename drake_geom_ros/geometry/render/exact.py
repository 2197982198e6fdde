"""``RenderEngineExact``: a ray casting renderer in compiled code, without a graphics library."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drake_geom_ros.geometry.render.exact_params import RenderEngineExactParams
from drake_geom_ros.geometry.render.render_engine import CameraShot, RenderedImages, RenderEngine
from drake_geom_ros.geometry.render.render_label import RenderLabel
from drake_geom_ros.sensors import ImageDepth32F, ImageLabel16I, ImageRgba8U

if TYPE_CHECKING:
    from drake_geom_ros.geometry.render._packing import Packed, PlacedBodies


def MakeRenderEngineExact(params: RenderEngineExactParams | None = None) -> RenderEngineExact:
    """Return a renderer that intersects the ray of each pixel, without a graphics library."""
    return RenderEngineExact(params or RenderEngineExactParams())


class RenderEngineExact(RenderEngine):
    """Renderer of the nearest surface along the ray of each pixel, exact within rounding.

    Rays intersect primitives in closed form, and the triangles of meshes, from both sides: a
    camera inside a body sees its inner side. Colours are opaque, lit from the camera and from
    above. Images of the same scene are equal to the last bit.
    """

    def __init__(self, params: RenderEngineExactParams) -> None:
        self._params = params

    def parameters(self) -> RenderEngineExactParams:
        """Return the parameters of the engine."""
        return self._params

    def default_render_label(self) -> RenderLabel:
        """Return the default label of geometry."""
        return self._params.default_label

    def _shown(self) -> RenderEngineExactParams:
        return self._params

    def _render(self, packed: Packed, bodies: PlacedBodies, shot: CameraShot) -> RenderedImages:
        """Return the images that a shot wants."""
        # Imported here: only images need it.
        from drake_geom_ros.geometry._rendering.drawing import (
            Lens,
            Shading,
            Wanted,
            bytes_of,
            render,
        )

        R_SW = shot.X_WS.rotation().matrix().T
        intrinsics, clipping = shot.core.intrinsics(), shot.core.clipping()
        lens = Lens(
            intrinsics.width(),
            intrinsics.height(),
            (intrinsics.focal_x(), intrinsics.focal_y()),
            (intrinsics.center_x(), intrinsics.center_y()),
            (clipping.near(), clipping.far()),
            shot.visible_depths(),
            R_SW[:, 2],
        )
        params = self._params
        look = Shading(params.default_clear_color.rgba[:3], params.edges, params.color_samples)
        images = render(
            packed.bodies,
            bodies.placed,
            R_SW @ bodies.R_WGs,
            (bodies.p_WGs - shot.X_WS.translation()) @ R_SW.T,
            lens,
            look,
            Wanted(*(name in shot.want for name in Wanted._fields)),
            int(RenderLabel.kEmpty),
        )
        return RenderedImages(
            ImageRgba8U.of(bytes_of(images.color)) if 'color' in shot.want else None,
            ImageDepth32F.of(images.depth) if 'depth' in shot.want else None,
            ImageLabel16I.of(images.label) if 'label' in shot.want else None,
        )
