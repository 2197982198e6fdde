"""Pictures of a scene for people, with transparent bodies and nearest points.

Transparent bodies are rendered frame by frame and blended by their depths at each pixel, so that
contents and background remain visible.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    ArgumentError,
    ClippingRange,
    ColorRenderCamera,
    GeometryError,
    GeometryId,
    GeometryInstance,
    HalfSpace,
    IllustrationProperties,
    MakeRenderEngineExact,
    PerceptionProperties,
    ProximityProperties,
    QueryObject,
    RenderCameraCore,
    RenderEngineExactParams,
    Rgba,
    Role,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import DIRECTION_NORM
from drake_geom_ros.sensors import CameraInfo
from drake_geom_ros.viewing.looks import colour_of, drawn_geometries, is_solid
from drake_geom_ros.viewing.overlays import with_pairs, with_patches
from drake_geom_ros.viewing.patches import Patches
from drake_geom_ros.viewing.shown_pairs import ReportedPairs

Pixels = NDArray[np.uint8]

_STEEP = 0.999  # cosine to the vertical beyond which +y, not +z, is up
_FITTINGS, _FILLED = 4, 0.92  # steps that move a camera, until this much of the image is filled
_NEAR, _FAR = 0.01, 1000.0  # [m] depth range of a camera
_SAMPLES = 2  # along each side of a pixel
_FROM = (1.0, -1.4, 0.9)  # direction to the default camera
_OPAQUE = 0.99
_BAND = 32  # rows that are blended at once, since many layers take much memory
_ROLES: dict[Role, tuple[Any, Any]] = {
    Role.kProximity: (ProximityProperties, GeometryInstance.set_proximity_properties),
    Role.kIllustration: (IllustrationProperties, GeometryInstance.set_illustration_properties),
    Role.kPerception: (PerceptionProperties, GeometryInstance.set_perception_properties),
}


@dataclass(frozen=True)
class Camera:
    """A camera with x to the right and z ahead: its pose X_WC, and its intrinsics."""

    X_WC: RigidTransform
    info: CameraInfo

    def pixels(self, p_WPs: Floats) -> Floats:
        """Return the image points (n, 2) [pixels] of points (n, 3) [m]; NaN if behind."""
        p_CPs = self.in_camera(p_WPs)
        z = np.where(p_CPs[:, 2] > _NEAR, p_CPs[:, 2], np.nan)
        info = self.info
        focal = np.array([info.focal_x(), info.focal_y()])
        centre = np.array([info.center_x(), info.center_y()])
        at: Floats = p_CPs[:, :2] / z[:, None] * focal + centre
        return at

    def in_camera(self, p_WPs: Floats) -> Floats:
        """Return points (n, 3) [m] in the camera's frame, z ahead."""
        p_CPs: Floats = (p_WPs - self.X_WC.translation()) @ self.X_WC.rotation().matrix()
        return p_CPs

    def core(self) -> RenderCameraCore:
        """Return the core parameters for a renderer named 'picture'."""
        return RenderCameraCore('picture', self.info, ClippingRange(_NEAR, _FAR), RigidTransform())


def looking(from_W: Sequence[float], at_W: Sequence[float]) -> RigidTransform:
    """Return X_WC of a camera at one point that looks at another, with its x axis level.

    Raises ArgumentError if the points coincide.
    """
    ahead = np.subtract(at_W, from_W, dtype=np.float64)
    length = float(np.linalg.norm(ahead))
    if not length > DIRECTION_NORM:
        raise ArgumentError(
            f'the camera is at {list(from_W)} and looks at {list(at_W)}, the same point: it needs '
            'a direction'
        )
    ahead /= length
    up = [0.0, 1.0, 0.0] if abs(ahead[2]) > _STEEP else [0.0, 0.0, 1.0]
    aside = np.cross(ahead, up)
    aside /= np.linalg.norm(aside)
    R_WC = RotationMatrix(np.column_stack((aside, np.cross(ahead, aside), ahead)))
    return RigidTransform(R_WC, from_W)


def camera_for(query: QueryObject, role: Role, size: tuple[int, int], fov_y: float) -> Camera:
    """Return a camera that sees all geometry of a role, half spaces ignored."""
    corners = [np.zeros((0, 3))]
    for id in drawn_geometries(query.inspector(), role):
        if (box := query.ComputeObbInWorld(id)) is not None:
            signs = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
            own = signs * box.half_width()
            X_WB = box.pose()
            corners.append(own @ X_WB.rotation().matrix().T + X_WB.translation())
    points = np.concatenate(corners)
    low, high = np.full(3, -1.0), np.full(3, 1.0)
    if len(points):
        low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high)
    radius = min(max(0.5 * float(np.linalg.norm(high - low)), _NEAR), 0.5 * _FAR)
    narrow = min(fov_y, 2.0 * math.atan(math.tan(0.5 * fov_y) * size[0] / size[1]))
    way = np.array(_FROM) / np.linalg.norm(_FROM)
    far = radius / math.sin(0.5 * narrow)
    for _ in range(_FITTINGS):  # move closer while all corners are visible
        start = middle + way * far
        camera = Camera(looking(start.tolist(), middle.tolist()), CameraInfo(*size, fov_y))
        off = np.abs(camera.pixels(points) / size - 0.5) * 2.0
        if not len(points) or not np.isfinite(off).all():
            break
        far = max(far * min(1.0, float(off.max()) / _FILLED), 1.2 * _NEAR)
    return camera


def picture(
    query: QueryObject,
    camera: Camera,
    role: Role = Role.kProximity,
    see_through: float = 1.0,
    pairs: ReportedPairs | None = None,
    patches: Patches | None = None,
) -> Pixels:
    """Return the pixels (height, width, 3) of a scene at its current poses.

    ``see_through`` is the opacity of bodies, 1: opaque; half spaces are always opaque. ``pairs``
    are drawn on top as lines between their nearest points, orange if they overlap, with distances.
    ``patches``, contact surfaces, are coloured by pressure, with a scale. Raises GeometryError
    for an opacity outside (0, 1].
    """
    if not 0.0 < see_through <= 1.0:
        raise GeometryError(f'see_through = {see_through} must be in (0, 1]')
    groups = _groups(query, role, see_through)
    layers = [_drawn(query, camera, role, ids, cover) for ids, cover in groups]
    bands = range(0, len(layers[0].colours), _BAND)
    pixels = np.concatenate([_blended(layers, slice(k, k + _BAND)) for k in bands])
    if patches is not None and len(patches):
        p_WVs = patches.vertices
        pixels = with_patches(pixels, camera.pixels(p_WVs), camera.in_camera(p_WVs)[:, 2], patches)
    if pairs is not None and len(pairs):
        ends = camera.pixels(pairs.segments().reshape(-1, 3)).reshape(-1, 2, 2)
        pixels = with_pairs(pixels, ends, pairs)
    return pixels


def _groups(
    query: QueryObject, role: Role, cover: float
) -> Iterator[tuple[list[GeometryId], float]]:
    """Yield geometries that are drawn together, and their opacity; half spaces first."""
    inspector = query.inspector()
    every = drawn_geometries(inspector, role)
    if cover >= _OPAQUE:
        yield every, 1.0
        return
    flat = [id for id in every if isinstance(inspector.GetShape(id), HalfSpace)]
    yield flat, 1.0
    bodies: dict[object, list[GeometryId]] = {}
    for id in every:
        if id not in flat:
            frame = inspector.GetFrameId(id)
            # Anchored geometries are separate bodies, although they share the world frame.
            key = id if frame == inspector.world_frame_id() else frame
            bodies.setdefault(key, []).append(id)
    for ids in bodies.values():
        yield ids, cover


class _Layer(NamedTuple):
    """Image of some geometries of a picture."""

    colours: Pixels  # (h, w, 3)
    depths: NDArray[np.float32]  # (h, w) [m]
    cover: float  # opacity


def _drawn(
    query: QueryObject, camera: Camera, role: Role, ids: list[GeometryId], cover: float
) -> _Layer:
    """Return the layer of some geometries, rendered without all others."""
    alone = SceneGraph()
    params = RenderEngineExactParams(color_samples=_SAMPLES if cover == 1.0 else 1, role=role)
    alone.AddRenderer('picture', MakeRenderEngineExact(params))
    source, inspector = alone.RegisterSource('picture'), query.inspector()
    for number, id in enumerate(ids):
        red, green, blue, _ = colour_of(inspector, id, role)
        instance = GeometryInstance(query.X_WG(id), inspector.GetShape(id), f'{number}')
        make, put = _ROLES[role]
        properties = make()
        properties.AddProperty('phong', 'diffuse', Rgba(red, green, blue, 1.0))
        if is_solid(inspector, id, role):  # otherwise the hull is drawn, as queries use it
            properties.AddProperty('mesh', 'solid', True)
        put(instance, properties)
        alone.RegisterAnchoredGeometry(source, instance)
    looked_at = alone.get_query_output_port().Eval(alone.CreateDefaultContext())
    images = looked_at.render_images(
        *(ColorRenderCamera(camera.core()), alone.world_frame_id(), camera.X_WC),
        want=('color', 'depth'),
    )
    assert images.color is not None
    assert images.depth is not None
    # Copied, since the views would keep the whole images alive.
    return _Layer(images.color.data[..., :3].copy(), images.depth.data[..., 0].copy(), cover)


def _blended(layers: list[_Layer], rows: slice) -> Pixels:
    """Return rows of blended layers, from the farthest to the nearest at each pixel."""
    colours = np.stack([layer.colours[rows] for layer in layers])
    depths = np.stack([layer.depths[rows] for layer in layers])
    is_hit = np.isfinite(depths) & (depths > 0.0)
    covers = np.array([layer.cover for layer in layers])
    order = np.argsort(np.where(is_hit, -depths, -np.inf), axis=0)
    # Empty pixels of each layer have the background's colour.
    blended = colours[0].astype(np.float64)
    most = int(is_hit.sum(axis=0).max())  # bodies at a pixel; empty layers are sorted first
    for rank in order[len(order) - most :]:
        at = rank[None]
        colour = np.take_along_axis(colours, at[..., None], axis=0)[0]
        seen = np.take_along_axis(is_hit, at, axis=0)[0]
        share = (covers[rank] * seen)[..., None]
        blended = share * colour + (1.0 - share) * blended
    pixels: Pixels = np.rint(blended).astype(np.uint8)
    return pixels
