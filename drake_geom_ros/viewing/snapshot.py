"""Pictures of a scene as it stands, for people: see-through bodies, and the nearest points.

Bodies that one can see through are drawn one frame's after the other, and laid over one another by
their depths at each pixel: what lies inside, or behind, stays in sight.
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
from drake_geom_ros.math.tolerances import DIRECTION_NORM
from drake_geom_ros.sensors import CameraInfo
from drake_geom_ros.viewing.looks import colour_of, is_solid
from drake_geom_ros.viewing.overlays import with_pairs, with_patches
from drake_geom_ros.viewing.pairs import Pairs
from drake_geom_ros.viewing.patches import Patches

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_STEEP = 0.999  # cosine to the vertical beyond which +y, not +z, is up
_FITTINGS, _FILLED = 4, 0.92  # how often a camera is moved, to fill so much of the image
_NEAR, _FAR = 0.01, 1000.0  # [m] what a camera sees
_SAMPLES = 2  # along each side of a pixel
_FROM = (1.0, -1.4, 0.9)  # from where a scene is looked at that nobody placed a camera for
_OPAQUE = 0.99
_BAND = 32  # rows that are laid over one another at once: a scene has many layers
_ROLES: dict[Role, tuple[Any, Any]] = {
    Role.kProximity: (ProximityProperties, GeometryInstance.set_proximity_properties),
    Role.kIllustration: (IllustrationProperties, GeometryInstance.set_illustration_properties),
    Role.kPerception: (PerceptionProperties, GeometryInstance.set_perception_properties),
}


@dataclass(frozen=True)
class Camera:
    """A camera, its x to the right and its z ahead: X_WC, and its intrinsics."""

    X_WC: RigidTransform
    info: CameraInfo

    def pixels(self, p_WPs: Floats) -> Floats:
        """Return where points (n, 3) [m] are in the image (n, 2); NaN for those behind."""
        p_CPs = self.in_camera(p_WPs)
        z = np.where(p_CPs[:, 2] > _NEAR, p_CPs[:, 2], np.nan)
        info = self.info
        focal = np.array([info.focal_x(), info.focal_y()])
        centre = np.array([info.center_x(), info.center_y()])
        found: Floats = p_CPs[:, :2] / z[:, None] * focal + centre
        return found

    def in_camera(self, p_WPs: Floats) -> Floats:
        """Return points (n, 3) [m] in the camera's frame, z ahead."""
        found: Floats = (p_WPs - self.X_WC.translation()) @ self.X_WC.rotation().matrix()
        return found

    def core(self) -> RenderCameraCore:
        """Return what a renderer takes, but for its name."""
        return RenderCameraCore('picture', self.info, ClippingRange(_NEAR, _FAR), RigidTransform())


def looking(from_W: Sequence[float], at_W: Sequence[float]) -> RigidTransform:
    """Return X_WC of a camera at one point that looks at another, its x level.

    Raises ArgumentError where they are no two points.
    """
    ahead = np.subtract(at_W, from_W, dtype=np.float64)
    length = float(np.linalg.norm(ahead))
    if not length > DIRECTION_NORM:
        raise ArgumentError(f'from {list(from_W)} and at {list(at_W)} must be two points')
    ahead /= length
    up = [0.0, 1.0, 0.0] if abs(ahead[2]) > _STEEP else [0.0, 0.0, 1.0]
    aside = np.cross(ahead, up)
    aside /= np.linalg.norm(aside)
    R_WC = RotationMatrix(np.column_stack((aside, np.cross(ahead, aside), ahead)))
    return RigidTransform(R_WC, from_W)


def camera_for(query: QueryObject, role: Role, size: tuple[int, int], fov_y: float) -> Camera:
    """Return a camera that has all geometry of a role in sight but half spaces."""
    corners = [np.zeros((0, 3))]
    for id in query.inspector().GetAllGeometryIds(role):
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
    for _ in range(_FITTINGS):  # nearer, as long as all corners are in sight
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
    pairs: Pairs | None = None,
    patches: Patches | None = None,
) -> Pixels:
    """Return the pixels (height, width, 3) of a scene as it stands.

    ``see_through`` is how much of a body covers what is behind it, 1: all of it; half spaces do.
    ``pairs`` are drawn as lines between their nearest points, over all else, red where bodies
    overlap, with their distances, and ``patches``, contact surfaces, by their pressures, with a
    scale. Raises GeometryError for another cover than in (0, 1].
    """
    if not 0.0 < see_through <= 1.0:
        raise GeometryError(f'see_through = {see_through} must be in (0, 1]')
    groups = _groups(query, role, see_through)
    layers = [_drawn(query, camera, role, ids, cover) for ids, cover in groups]
    bands = range(0, len(layers[0].colours), _BAND)
    found = np.concatenate([_laid_over(layers, slice(k, k + _BAND)) for k in bands])
    if patches is not None and len(patches):
        p_WVs = patches.vertices
        found = with_patches(found, camera.pixels(p_WVs), camera.in_camera(p_WVs)[:, 2], patches)
    if pairs is not None and len(pairs):
        ends = camera.pixels(pairs.segments().reshape(-1, 3)).reshape(-1, 2, 2)
        found = with_pairs(found, ends, pairs)
    return found


def _groups(
    query: QueryObject, role: Role, cover: float
) -> Iterator[tuple[list[GeometryId], float]]:
    """Yield geometries that are drawn together, and how much they cover; half spaces first."""
    inspector = query.inspector()
    every = inspector.GetAllGeometryIds(role)
    if cover >= _OPAQUE:
        yield every, 1.0
        return
    flat = [id for id in every if isinstance(inspector.GetShape(id), HalfSpace)]
    yield flat, 1.0
    bodies: dict[object, list[GeometryId]] = {}
    for id in every:
        if id not in flat:
            frame = inspector.GetFrameId(id)
            # What stands on the world is many bodies.
            key = id if frame == inspector.world_frame_id() else frame
            bodies.setdefault(key, []).append(id)
    for ids in bodies.values():
        yield ids, cover


class _Layer(NamedTuple):
    """Some geometries of a picture."""

    colours: Pixels  # (h, w, 3)
    depths: NDArray[np.float32]  # (h, w) [m]
    cover: float  # how much of what is behind them they cover


def _drawn(
    query: QueryObject, camera: Camera, role: Role, ids: list[GeometryId], cover: float
) -> _Layer:
    """Return some geometries alone."""
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
        if is_solid(inspector, id, role):  # else its hull is what distances are measured of
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
    # Copies, for the images hold more than that.
    return _Layer(images.color.data[..., :3].copy(), images.depth.data[..., 0].copy(), cover)


def _laid_over(layers: list[_Layer], rows: slice) -> Pixels:
    """Return rows of layers over one another, by their depths at each pixel, farthest first."""
    colours = np.stack([layer.colours[rows] for layer in layers])
    depths = np.stack([layer.depths[rows] for layer in layers])
    there = np.isfinite(depths) & (depths > 0.0)
    covers = np.array([layer.cover for layer in layers])
    order = np.argsort(np.where(there, -depths, -np.inf), axis=0)
    # Of what is drawn alone an empty pixel has the background.
    found = colours[0].astype(np.float64)
    most = int(there.sum(axis=0).max())  # bodies at a pixel: what is empty comes first
    for rank in order[len(order) - most :]:
        at = rank[None]
        colour = np.take_along_axis(colours, at[..., None], axis=0)[0]
        seen = np.take_along_axis(there, at, axis=0)[0]
        share = (covers[rank] * seen)[..., None]
        found = share * colour + (1.0 - share) * found
    pixels: Pixels = np.rint(found).astype(np.uint8)
    return pixels
