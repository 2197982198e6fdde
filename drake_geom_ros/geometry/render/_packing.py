"""Arrays of a renderer's geometry: packed once per version of a model, posed for every image."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kinds import CONVEX, HALF_SPACE, SPHERE
from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry._rendering.kernels.records import Bodies
from drake_geom_ros.geometry._rendering.tolerances import LARGEST_SIZE, SMALLEST_SIZE
from drake_geom_ros.geometry.errors import ArgumentError, GeometryError, RoleError
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.meshes.source import facet_colours
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model._records import GeometryRecord, named
from drake_geom_ros.geometry.model.properties import GeometryProperties, Role
from drake_geom_ros.geometry.model.rgba import Rgba
from drake_geom_ros.geometry.render.render_label import RenderLabel
from drake_geom_ros.geometry.shapes.from_meshes import Convex, Mesh, mesh_of
from drake_geom_ros.geometry.shapes.primitives import MeshcatCone, Shape, Sphere, for_queries
from drake_geom_ros.geometry.shapes.sensed import OccupiedCells, PointCloud
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import compose

if TYPE_CHECKING:
    from drake_geom_ros.geometry.render.exact_params import RenderEngineExactParams


# Default colours of frames, of equal lightness; that of the world is the palest.
_PALETTE = tuple(
    Rgba(r, g, b)
    for r, g, b in (
        *((0.78, 0.76, 0.72), (0.90, 0.56, 0.28), (0.36, 0.62, 0.84), (0.47, 0.72, 0.43)),
        *((0.84, 0.45, 0.46), (0.66, 0.54, 0.80), (0.86, 0.76, 0.36), (0.42, 0.70, 0.70)),
    )
)


class PlacedBodies(NamedTuple):
    """Poses of bodies in World, and the mask of those that have one."""

    R_WGs: Floats  # (n, 3, 3)
    p_WGs: Floats  # (n, 3) [m]
    placed: NDArray[np.bool_]  # (n,)


class Packed(NamedTuple):
    """The bodies that a renderer shows, by ascending id, and their poses in frames.

    Each ball of a PointCloud is a body of its own, under the same id.
    """

    ids: list[GeometryId]
    names: list[str]  # for messages
    shapes: list[Shape]
    diffuse_maps: list[str]  # image files of ('phong', 'diffuse_map'); empty: none
    frames: NDArray[np.int64]  # (n,) rows of the world
    R_FGs: Floats  # (n, 3, 3)
    p_FGs: Floats  # (n, 3) [m]
    bodies: Bodies

    def placed_in(self, world: World) -> PlacedBodies:
        """Return the poses of the bodies in a world.

        Raises GeometryError for one that is too far away for images.
        """
        world.update()
        R_WFs, p_WFs = world.R_WFs[self.frames], world.p_WFs[self.frames]
        R_WGs, p_WGs = compose(R_WFs, p_WFs, self.R_FGs, self.p_FGs)
        placed = world.placed[self.frames]
        reach = np.abs(p_WGs).max(axis=1, initial=0.0)
        for row in np.flatnonzero((reach > LARGEST_SIZE) & placed)[:1].tolist():
            raise GeometryError(
                f'{self.names[row]} lies at {p_WGs[row].tolist()} m; images show what is within '
                f'{LARGEST_SIZE:g} m'
            )
        return PlacedBodies(R_WGs, p_WGs, placed)


def packed_of(model: Model, params: RenderEngineExactParams, renderer_name: str) -> Packed:
    """Return the bodies of a model that a renderer shows.

    Raises GeometryError with the geometry's name for an invalid label or colour, a missing label
    that is required, a shape that cannot be rendered, and sizes beyond the limits of images.
    """
    shown = [record for record in model.geometries.values() if record.has_role(params.role)]
    records = sorted(
        (record for record in shown if _accepts(record, params.role, renderer_name)),
        key=lambda record: record.id,
    )
    rows = {frame: row for row, frame in enumerate(model.frames)}
    own_labels = [_label(record, params) for record in records]
    all_labels = _numbered(own_labels) if params.number_geometries else own_labels
    labels = np.array(all_labels, dtype=np.int16)
    kinds = np.array([_kind(record) for record in records], dtype=np.int64)
    shapes = np.array([_sizes(record) for record in records]).reshape(-1, 3)
    colours = np.array([_colour(r, params, rows[r.frame_id]) for r in records]).reshape(-1, 3)
    R_FGs = np.array([record.X_FG.rotation().matrix() for record in records]).reshape(-1, 3, 3)
    p_FGs = np.array([record.X_FG.translation() for record in records]).reshape(-1, 3)
    meshes = [_mesh(record) for record in records]
    places = [_places(record) for record in records]
    of = np.repeat(np.arange(len(records)), list(map(len, places)))  # the record of each body
    p_GBs = np.concatenate([np.zeros((0, 3)), *places])
    # Geometries of several bodies have no facets.
    of_vertices, of_faces = (
        np.array([len(part) for part in parts], dtype=np.int64)[of]
        for parts in ([m.vertices for m in meshes], [m.triangles for m in meshes])
    )
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)], dtype=np.int64)
    faces = [m.triangles + start for m, start in zip(meshes, starts[:-1].tolist(), strict=True)]
    bodies = Bodies(
        kinds=kinds[of],
        shapes=shapes[of],
        colours=colours[of],
        labels=labels[of],
        is_labelled=labels[of] != int(RenderLabel.kDoNotRender),
        vertex_starts=np.concatenate(([0], np.cumsum(of_vertices))),
        p_GVs=np.concatenate([np.zeros((0, 3)), *(mesh.vertices for mesh in meshes)]),
        triangle_starts=np.concatenate(([0], np.cumsum(of_faces))),
        triangles=np.concatenate([np.zeros((0, 3), np.int32), *faces]).astype(np.int32),
        facet_colours=np.concatenate([np.zeros((0, 3), np.float32), *(m.colours for m in meshes)]),
    )
    maps = [str(_looks(record, params.role, 'diffuse_map') or '') for record in records]
    drawn = [
        Sphere(record.shape.radius()) if isinstance(record.shape, PointCloud) else record.shape
        for record in records
    ]
    frames = np.array([rows[record.frame_id] for record in records], dtype=np.int64)
    return Packed(
        [records[k].id for k in of],
        [named(records[k]) for k in of],
        [drawn[k] for k in of],
        [maps[k] for k in of],
        frames[of],
        R_FGs[of],
        (R_FGs[of] @ p_GBs[..., np.newaxis])[..., 0] + p_FGs[of],
        bodies,
    )


def _property(record: GeometryRecord, roles: tuple[Role, ...], group: str, name: str) -> Any:
    """Return a property from the first role that has it, or None."""
    for role in roles:
        properties: GeometryProperties | None = record.properties(role)
        if properties is not None and properties.HasProperty(group, name):
            return properties.GetProperty(group, name)
    return None


def _accepts(record: GeometryRecord, role: Role, renderer_name: str) -> bool:
    """Return whether ('renderer', 'accepting'), one or several names, allows a renderer.

    No names allow every renderer, as in Drake.
    """
    accepting = _property(record, (role,), 'renderer', 'accepting')
    if accepting is None:
        return True
    names = {accepting} if isinstance(accepting, str) else set(accepting)
    return not names or renderer_name in names


def _label(record: GeometryRecord, params: RenderEngineExactParams) -> int:
    """Return the label of a geometry, or the default."""
    label = _property(record, (params.role, Role.kPerception), 'label', 'id')
    if label is None:
        if params.default_label == RenderLabel.kUnspecified and not params.number_geometries:
            raise RoleError(
                f"{named(record)} has no property ('label', 'id'), and the renderer's "
                'default_label is kUnspecified: give it one, or the renderer kDontCare'
            )
        return int(params.default_label)
    if not isinstance(label, RenderLabel):
        label = RenderLabel(label)
    if label in (RenderLabel.kUnspecified, RenderLabel.kEmpty):
        raise ArgumentError(f'{named(record)} has the label {label!r}, which no geometry may have')
    return int(label)


def _numbered(labels: list[int]) -> list[int]:
    """Return labels with the lowest free numbers, from 1, in place of default ones."""
    taken = set(labels)
    free = (n for n in range(1, RenderLabel.kMaxUnreserved + 1) if n not in taken)
    without = int(RenderLabel.kDontCare), int(RenderLabel.kUnspecified)
    return [next(free, without[0]) if label in without else label for label in labels]


def _looks(record: GeometryRecord, role: Role, name: str) -> Any:
    """Return the property ('phong', name) of a geometry, or None."""
    # Proximity properties have no colour, so those of other roles are used.
    others = (Role.kPerception, Role.kIllustration) if role is Role.kProximity else ()
    return _property(record, (role, *others), 'phong', name)


def _colour(record: GeometryRecord, params: RenderEngineExactParams, frame: int) -> Floats:
    """Return red, green and blue (3,) of a geometry, whose frame is in this row."""
    diffuse = _looks(record, params.role, 'diffuse')
    if diffuse is None:
        diffuse = params.default_diffuse or _PALETTE[frame % len(_PALETTE)]
    if not isinstance(diffuse, Rgba):
        values = np.asarray(diffuse, dtype=np.float64)
        if values.shape not in ((3,), (4,)):
            raise ArgumentError(
                f"{named(record)}: ('phong', 'diffuse') = {diffuse!r} is no colour"
            )
        diffuse = Rgba(*values.tolist())
    return diffuse.rgba[:3]


def _kind(record: GeometryRecord) -> int:
    """Return the kind of the bodies of a geometry; a mesh has the kind CONVEX."""
    shape = record.shape
    if isinstance(shape, MeshcatCone):
        raise GeometryError(f'{named(record)} is a MeshcatCone, which images do not show')
    if isinstance(shape, PointCloud):
        return SPHERE
    if isinstance(shape, (Convex, Mesh, OccupiedCells)):
        return CONVEX
    return int(for_queries(shape).in_pairs.kind)


def _places(record: GeometryRecord) -> Floats:
    """Return the positions (k, 3) [m] of the bodies of a geometry: one, or one for each ball."""
    shape = record.shape
    return shape.positions() if isinstance(shape, PointCloud) else np.zeros((1, 3))


def _sizes(record: GeometryRecord) -> Floats:
    """Return the parameters (3,) of a primitive; zeros for a mesh."""
    shape, numbers = record.shape, np.zeros(3)
    if isinstance(shape, (Convex, Mesh, OccupiedCells)):
        return numbers
    if isinstance(shape, PointCloud):
        kind, parameters = SPHERE, np.array([shape.radius()])
    else:
        kind, parameters = for_queries(shape).in_pairs
    numbers[: len(parameters)] = parameters
    small = (parameters < SMALLEST_SIZE).any() and kind not in (SPHERE, HALF_SPACE)
    if small or (parameters > LARGEST_SIZE).any():
        raise GeometryError(
            f'{named(record)} is {shape!r}; images show sizes from {SMALLEST_SIZE:g} to '
            f'{LARGEST_SIZE:g} m'
        )
    return numbers


class _Facets(NamedTuple):
    """Vertices (v, 3) [m], triangles (f, 3) of them and the colours (f, 3) of these."""

    vertices: Floats
    triangles: NDArray[np.int64]
    colours: NDArray[np.float32]


_NO_FACETS = _Facets(np.zeros((0, 3)), np.zeros((0, 3), np.int64), np.zeros((0, 3), np.float32))


def _mesh(record: GeometryRecord) -> _Facets:
    """Return the facets of a mesh; none for others."""
    shape = record.shape
    if isinstance(shape, Mesh):
        vertices, triangles = shape.surface()
        colours = facet_colours(mesh_of(shape))
    elif isinstance(shape, Convex):
        vertices, triangles = shape.hull_surface()
        colours = None
    elif isinstance(shape, OccupiedCells):
        vertices, triangles = shape.surface()
        colours = None
    else:
        return _NO_FACETS
    if (np.abs(vertices) > LARGEST_SIZE).any():
        raise GeometryError(
            f'{named(record)} reaches to {np.abs(vertices).max():g} m; images show sizes up to '
            f'{LARGEST_SIZE:g} m'
        )
    if colours is None:
        colours = np.full((len(triangles), 3), -1.0, np.float32)
    return _Facets(np.ascontiguousarray(vertices), triangles, colours)
