"""Looks of geometries in the page and in RViz: layer, colour, solid or hull."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    Convex,
    GeometryId,
    GeometryProperties,
    HalfSpace,
    Mesh,
    Rgba,
    Role,
    SceneGraphInspector,
    Shape,
)

Colour = tuple[float, float, float, float]

# Names of the layers, one for each role.
LAYERS = {
    Role.kProximity: 'proximity',
    Role.kIllustration: 'illustration',
    Role.kPerception: 'perception',
}
# Okabe and Ito, "Color universal design", 2008, which the colour-blind can distinguish, without
# black, and without vermilion and yellow, which mark contacts and the selection.
PALETTE = (
    (0.34, 0.71, 0.91),
    (0.90, 0.62, 0.00),
    (0.00, 0.62, 0.45),
    (0.60, 0.60, 0.60),
    (0.80, 0.47, 0.65),
    (0.00, 0.45, 0.70),
)
_GROUND = (0.75, 0.75, 0.75)
# Transparent, so that points inside, such as the deepest one of an overlap, are visible.
_PROXIMITY_ALPHA = 0.45
# Colours of overlapping pairs, of their normals, and of the gaps of other pairs: orange and blue,
# which the colour-blind can distinguish, too.
PAIR_COLOURS: dict[str, Colour] = {
    'contacts': (0.95, 0.35, 0.0, 1.0),
    'normals': (1.0, 0.8, 0.0, 1.0),
    'distances': (0.1, 0.35, 1.0, 1.0),
}
# Colours of sensed cells that are new and that are about to be stale, of stale ones, of those
# beside bodies, and of those that bodies hide from the sensor.
MAP_AGES: tuple[Colour, Colour] = ((0.00, 0.45, 0.70, 0.9), (0.90, 0.62, 0.00, 0.9))
STALE_COLOUR: Colour = (0.84, 0.37, 0.00, 0.9)
SHELL_COLOUR: Colour = (0.94, 0.89, 0.26, 0.9)
SHADOW_COLOUR: Colour = (0.80, 0.47, 0.65, 0.9)
NORMAL_LENGTH = 0.1  # [m]
MOST_DRAWN = 50_000  # triangles of a solid; rclpy takes about 0.3 s for such a marker


@dataclass(frozen=True)
class Look:
    """A geometry in one of its roles; ``name`` is ``source::frame/geometry``."""

    geometry: GeometryId
    role: Role
    name: str
    colour: Colour
    shape: Shape
    solid: bool


def looks_of(inspector: SceneGraphInspector) -> list[Look]:
    """Return the looks of a scene's geometries, one for each of their roles."""
    return [
        Look(
            geometry,
            role,
            geometry_name(inspector, geometry),
            colour_of(inspector, geometry, role),
            inspector.GetShape(geometry),
            is_solid(inspector, geometry, role),
        )
        for role in LAYERS
        for geometry in drawn_geometries(inspector, role)
    ]


def drawn_geometries(inspector: SceneGraphInspector, role: Role) -> list[GeometryId]:
    """Return the geometries of a role that pictures show."""
    return [
        geometry
        for geometry in inspector.GetAllGeometryIds(role)
        if is_drawn(inspector.GetProperties(geometry, role))
    ]


def is_drawn(properties: GeometryProperties | None) -> bool:
    """Return whether pictures show a geometry with these properties of a role.

    They do unless its property ('renderer', 'accepting') is the empty name, which no renderer
    has. A set of no names is for every renderer.
    """
    if properties is None or not properties.HasProperty('renderer', 'accepting'):
        return True
    return properties.GetProperty('renderer', 'accepting') not in ('', {''})


def geometry_name(inspector: SceneGraphInspector, geometry: GeometryId) -> str:
    """Return ``source::frame/geometry``."""
    frame = inspector.GetName(inspector.GetFrameId(geometry))
    return f'{inspector.GetOwningSourceName(geometry)}::{frame}/{inspector.GetName(geometry)}'


def is_solid(inspector: SceneGraphInspector, geometry: GeometryId, role: Role) -> bool:
    """Return whether queries treat a mesh as a solid; in other roles its hull is drawn."""
    return solid_by(inspector.GetProperties(geometry, role), role)


def solid_by(properties: GeometryProperties | None, role: Role) -> bool:
    """Return whether the properties of a role make a mesh a solid."""
    return (
        role is Role.kProximity
        and properties is not None
        and bool(properties.GetPropertyOrDefault('mesh', 'solid', False))
    )


def colour_of(inspector: SceneGraphInspector, geometry: GeometryId, role: Role) -> Colour:
    """Return the property ('phong', 'diffuse') of a role, or the colour of the source."""
    rank = inspector.GetAllSourceIds().index(inspector.GetOwningSourceId(geometry))
    shape = inspector.GetShape(geometry)
    return colour_by(inspector.GetProperties(geometry, role), role, rank, shape)


def colour_by(
    properties: GeometryProperties | None, role: Role, rank: int, shape: Shape
) -> Colour:
    """Return the colour by the properties of a role, or by the rank of the source.

    Sources take the colours of the palette in the order of their ids. A half space is grey, since
    it may fill the whole picture. The proximity role is drawn transparent.
    """
    if properties is not None and properties.HasProperty('phong', 'diffuse'):
        value = properties.GetProperty('phong', 'diffuse')
        if isinstance(value, Rgba):
            return value.r(), value.g(), value.b(), value.a()
        if np.shape(value) == (4,):
            r, g, b, a = map(float, value)
            return r, g, b, a
    # The first source is the scene's own, which has no geometry.
    of_source = PALETTE[(rank - 1) % len(PALETTE)]
    red, green, blue = _GROUND if isinstance(shape, HalfSpace) else of_source
    return red, green, blue, _PROXIMITY_ALPHA if role is Role.kProximity else 1.0


def mesh_surface(
    shape: Convex | Mesh, solid: bool
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return vertices (n, 3) [m] and triangles (m, 3) of a mesh as queries treat it.

    This is its hull, or its own surface if it is a solid of no more than MOST_DRAWN triangles.
    Raises MeshFileError for a file that is no mesh.
    """
    if solid and isinstance(shape, Mesh):
        vertices, triangles = shape.surface()
        if len(triangles) <= MOST_DRAWN:
            return vertices, triangles
    return shape.hull_surface()
