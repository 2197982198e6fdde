"""Queries for images."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentError, GeometryError
from drake_geom_ros.geometry.ids import FrameId, GeometryId
from drake_geom_ros.geometry.queries.context_state import ContextState
from drake_geom_ros.geometry.render.camera_properties import (
    Camera,
    CameraProperties,
    DepthCameraProperties,
    core_of,
    depth_camera_of,
)
from drake_geom_ros.geometry.render.cameras import (
    ColorRenderCamera,
    DepthRenderCamera,
    refuse_window,
)
from drake_geom_ros.geometry.render.render_engine import (
    CameraShot,
    RenderedImages,
    images_of,
    shown_by,
)
from drake_geom_ros.geometry.render.renderers import Renderers
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensors import ImageDepth32F, ImageLabel16I, ImageRgba8U

if TYPE_CHECKING:
    from drake_geom_ros.geometry.render._packing import Packed
    from drake_geom_ros.geometry.render.render_engine import RenderEngine

_KINDS = frozenset(('color', 'depth', 'label'))


class _CachedScene(NamedTuple):
    """A packed scene, and the key that it is valid for."""

    key: tuple[object, ...]
    packed: Packed


class ImageQueries:
    """Base of ``QueryObject`` with the queries for images.

    A camera's body C is posed by ``X_PC`` in a frame P. The camera looks along +z, x is to the
    right and y down; see CameraInfo for the rays of pixels. A renderer shows geometry with the
    perception role that accepts it: ``('renderer', 'accepting')`` is a name or a set of names.
    """

    _state: ContextState

    def RenderColorImage(
        self,
        camera: ColorRenderCamera | CameraProperties,
        parent_frame: FrameId,
        X_PC: RigidTransform,
        show_window: bool = False,
    ) -> ImageRgba8U:
        """Return the colour image of a camera, with ('phong', 'diffuse') or colours of mesh files.

        Raises GeometryError for an unknown renderer or frame, for an object that is no camera, and
        for ``show_window=True``.
        """
        refuse_window(show_window)
        image = self.render_images(camera, parent_frame, X_PC, ('color',)).color
        assert image is not None
        return image

    def RenderDepthImage(
        self,
        camera: DepthRenderCamera | DepthCameraProperties,
        parent_frame: FrameId,
        X_PC: RigidTransform,
    ) -> ImageDepth32F:
        """Return the depth image of a camera [m]: z in the sensor's frame.

        It is 0 below the camera's minimum depth, and infinity above its maximum and where there is
        no geometry. Raises as RenderColorImage.
        """
        image = self.render_images(camera, parent_frame, X_PC, ('depth',)).depth
        assert image is not None
        return image

    def RenderLabelImage(
        self,
        camera: ColorRenderCamera | CameraProperties,
        parent_frame: FrameId,
        X_PC: RigidTransform,
        show_window: bool = False,
    ) -> ImageLabel16I:
        """Return the label image of a camera, of the property ('label', 'id'); see RenderLabel.

        Raises as RenderColorImage.
        """
        refuse_window(show_window)
        image = self.render_images(camera, parent_frame, X_PC, ('label',)).label
        assert image is not None
        return image

    def render_images(
        self,
        camera: Camera,
        parent_frame: FrameId,
        X_PC: RigidTransform,
        want: Iterable[str] = ('color', 'depth', 'label'),
    ) -> RenderedImages:
        """Return several images of one camera, made in one pass: 'color', 'depth', 'label'.

        A camera without a depth range has depths of any size. Raises as RenderColorImage.
        """
        wanted = frozenset((want,) if isinstance(want, str) else want)
        if not wanted <= _KINDS:
            raise ArgumentError(
                f'render_images: want = {sorted(wanted)} must be of {sorted(_KINDS)}'
            )
        if isinstance(camera, DepthCameraProperties):
            camera = depth_camera_of(camera)
        depth_range = camera.depth_range() if isinstance(camera, DepthRenderCamera) else None
        if not isinstance(camera, CameraProperties | ColorRenderCamera | DepthRenderCamera):
            raise ArgumentError(f'an image was asked for of {camera!r}, which is no camera')
        checked_type(X_PC, RigidTransform, 'X_PC')
        try:
            core = core_of(camera)
        except GeometryError:
            raise
        except RuntimeError as error:  # of the camera's intrinsics
            raise ArgumentError(str(error)) from None
        engine = Renderers(self._state.model).find(core.renderer_name(), 'an image')
        X_WS = self._state.X_WF(parent_frame) @ X_PC @ core.sensor_pose_in_camera_body()
        packed = self._packed(engine, core.renderer_name())
        bodies = packed.placed_in(self._state.posed_world())
        return images_of(engine, packed, bodies, CameraShot(core, X_WS, depth_range, wanted))

    def _packed(self, engine: RenderEngine, renderer_name: str) -> Packed:
        """Return the geometry of a renderer, packed once per version of the model."""
        # Imported here: other queries need no renderer.
        from drake_geom_ros.geometry.render._packing import packed_of

        state, shown = self._state, shown_by(engine)
        versions = state.model.versions
        key = renderer_name, engine, versions.frames, versions.roles[shown.role]
        # Snapshots share packed scenes, which are never changed.
        cached: _CachedScene | None = state.packed_scenes.get(renderer_name)
        if cached is None or cached.key != key:
            cached = _CachedScene(key, packed_of(state.model, shown, renderer_name))
            state.packed_scenes[renderer_name] = cached
        return cached.packed

    def image_state(self) -> bytes:
        """Return a digest of poses and geometry that changes whenever an image may change."""
        state = self._state
        world = state.up_to_date_world()
        world.update()
        digest = hashlib.blake2b(str(state.model.versions.any).encode())
        for part in (world.R_WFs, world.p_WFs, world.placed):
            digest.update(part.tobytes())
        return digest.digest()

    def render_legend(self, renderer_name: str) -> dict[GeometryId, int]:
        """Return the label of each geometry of a renderer; raises GeometryError for unknown names.

        Geometry without a label of its own gets the renderer's default, or, where the renderer
        numbers them, a label of its own.
        """
        engine = Renderers(self._state.model).find(renderer_name, 'a legend')
        packed = self._packed(engine, renderer_name)
        return dict(zip(packed.ids, packed.bodies.labels.tolist(), strict=True))
