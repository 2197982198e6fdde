"""``RenderEngineVtk``: a renderer with textures, glTF and light, by the optional VTK."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.model.rgba import Rgba
from drake_geom_ros.geometry.render.exact_params import RenderEngineExactParams
from drake_geom_ros.geometry.render.render_engine import CameraShot, RenderedImages, RenderEngine
from drake_geom_ros.geometry.render.render_label import RenderLabel
from drake_geom_ros.sensors import ImageDepth32F, ImageLabel16I, ImageRgba8U

if TYPE_CHECKING:
    from drake_geom_ros.geometry.render._packing import Packed, PlacedBodies
    from drake_geom_ros.geometry.render.vtk.stage import Stage

_MOST_STAGES = 4  # scenes whose actors are cached, each with its own context
_LARGEST = 16384  # [pixels] a side, the limit of drivers


@dataclass(frozen=True)
class RenderEngineVtkParams:
    """Parameters of a renderer by VTK, which shows the geometry with the perception role.

    - ``default_label``: of geometry without ('label', 'id'); kUnspecified refuses such geometry.
    - ``default_diffuse``: of geometry without a colour.
    - ``default_clear_color``: of the background.
    """

    default_label: RenderLabel = RenderLabel.kDontCare
    default_diffuse: Rgba = field(default_factory=lambda: Rgba(0.9, 0.7, 0.2))
    default_clear_color: Rgba = field(default_factory=lambda: Rgba(0.8, 0.9, 1.0))

    def __post_init__(self) -> None:
        self._shown()

    def _shown(self) -> RenderEngineExactParams:
        """Return the parameters that select, label and colour the geometry."""
        return RenderEngineExactParams(
            default_label=self.default_label,
            default_diffuse=self.default_diffuse,
            default_clear_color=self.default_clear_color,
        )


def MakeRenderEngineVtk(params: RenderEngineVtkParams | None = None) -> RenderEngineVtk:
    """Return a renderer by VTK, which shows textures and glTF materials.

    Raises GeometryError, with the packages to install, if VTK is missing or cannot draw.
    """
    # Imported here: only images need it.
    from drake_geom_ros.geometry.render.vtk.probing import why_not

    if reason := why_not():
        raise GeometryError(f'MakeRenderEngineVtk: {reason}')
    return RenderEngineVtk(params or RenderEngineVtkParams())


class RenderEngineVtk(RenderEngine):
    """Renderer of triangles by OpenGL, with or without a graphics card.

    Round shapes are tessellated, with an error of 1.2e-3 of a radius; half spaces are plates of
    100 m. Colours are lit from the camera. A mesh has the materials of its glTF or .obj file, the
    texture ('phong', 'diffuse_map'), or that of an image with its name beside it. Depth has steps
    of 6e-8 of the farthest surface. One thread owns OpenGL's context, and calls wait for it.
    """

    def __init__(self, params: RenderEngineVtkParams) -> None:
        self._params = params
        self._thread = ThreadPoolExecutor(1, thread_name_prefix='vtk')
        self._stages: list[Stage] = []  # used by that thread only, least recently used first
        self._closing = weakref.finalize(self, _close, self._thread, self._stages)
        # At the end of the process everything is released anyway.
        self._closing.atexit = False

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return RenderEngineVtk, (self._params,)

    def parameters(self) -> RenderEngineVtkParams:
        """Return the parameters of the engine."""
        return self._params

    def default_render_label(self) -> RenderLabel:
        """Return the default label of geometry."""
        return self._params.default_label

    def _shown(self) -> RenderEngineExactParams:
        return self._params._shown()

    def _render(self, packed: Packed, bodies: PlacedBodies, shot: CameraShot) -> RenderedImages:
        """Return the images that a shot wants."""
        size = shot.core.intrinsics().width(), shot.core.intrinsics().height()
        if max(size) > _LARGEST:
            raise GeometryError(
                f'an image of {size[0]} x {size[1]} was asked of VTK, which draws at most '
                f'{_LARGEST} pixels a side; MakeRenderEngineExact has no such limit'
            )
        R_SW = shot.X_WS.rotation().matrix().T
        posed = (
            R_SW @ bodies.R_WGs,
            (bodies.p_WGs - shot.X_WS.translation()) @ R_SW.T,
            bodies.placed,
        )
        return self._thread.submit(self._draw, packed, posed, shot).result()

    def _draw(
        self,
        packed: Packed,
        posed: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]],
        shot: CameraShot,
    ) -> RenderedImages:
        """Return images, drawn in the thread that owns the context."""
        from drake_geom_ros.geometry.render.vtk.stage import View

        stage = self._stage(packed)
        intrinsics, clipping = shot.core.intrinsics(), shot.core.clipping()
        near = clipping.near()
        # The far plane is at the end of the last body, so that depths have fine steps.
        far = min(clipping.far(), max(1.001 * stage.pose(*posed), 1.001 * near))
        view = View(
            intrinsics.width(),
            intrinsics.height(),
            (intrinsics.focal_x(), intrinsics.focal_y()),
            (intrinsics.center_x(), intrinsics.center_y()),
            near,
            far,
        )
        color = ImageRgba8U.of(stage.color(view)) if 'color' in shot.want else None
        depth = label = None
        if 'depth' in shot.want:
            low, high = shot.visible_depths()
            depths = stage.depth(view)
            depths[depths > high] = np.inf
            depths[depths < low] = 0.0
            depth = ImageDepth32F.of(depths.astype(np.float32)[..., None])
        if 'label' in shot.want:
            label = ImageLabel16I.of(stage.label(view, int(RenderLabel.kEmpty))[..., None])
        return RenderedImages(color, depth, label)

    def _stage(self, packed: Packed) -> Stage:
        """Return the actors of a packed scene, made if they are not cached."""
        from drake_geom_ros.geometry.render.vtk.stage import Stage

        for stage in self._stages:
            if stage.packed is packed:
                self._stages.remove(stage)
                break
        else:
            stage = Stage(packed, self._params.default_clear_color.rgba[:3])
        self._stages.append(stage)
        while len(self._stages) > _MOST_STAGES:
            self._stages.pop(0).close()
        return stage


def _close(thread: ThreadPoolExecutor, stages: list[Stage]) -> None:
    """Release the contexts of an engine that was garbage collected."""

    def close() -> None:
        while stages:
            stages.pop().close()

    thread.submit(close)
    thread.shutdown(wait=False)
