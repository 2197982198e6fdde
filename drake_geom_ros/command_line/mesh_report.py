"""Section of ``check`` about meshes, with warnings about sizes that suggest a wrong unit."""

from collections.abc import Iterator
from pathlib import Path

from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.geometry import Convex, GeometryId, Mesh, Role, Shape
from drake_geom_ros.geometry.shapes.mesh_facts import MeshFacts, mesh_facts
from drake_geom_ros.math.tolerances import LARGEST_PART, SMALLEST_PART


def mesh_lines(scene: OpenedScene) -> Iterator[str]:
    """Yield a line for each geometry that is a mesh, and warnings below; nothing without any."""
    title = 'meshes'
    for geometry in scene.inspector.GetAllGeometryIds():
        shape = scene.inspector.GetShape(geometry)
        if isinstance(shape, (Convex, Mesh)):
            if title:
                yield title
            title = ''
            facts = mesh_facts(shape)
            yield f'  {scene.names[geometry]}: {_line(shape, is_solid(scene, geometry), facts)}'
            if warning := _warning(facts):
                yield f'warning: {scene.names[geometry]}: {warning}'


def is_solid(scene: OpenedScene, geometry: GeometryId) -> bool:
    """Return whether queries treat a mesh as a solid."""
    properties = scene.inspector.GetProperties(geometry, Role.kProximity)
    return properties is not None and bool(properties.GetPropertyOrDefault('mesh', 'solid', False))


def file_name(shape: Convex | Mesh) -> str:
    """Return the name of a mesh's file, without its folder."""
    return 'in memory' if shape.mesh_data() is not None else Path(shape.filename()).name


def _line(shape: Shape, solid: bool, facts: MeshFacts) -> str:
    assert isinstance(shape, (Convex, Mesh))
    low, high = (', '.join(f'{x + 0.0:.6g}' for x in end) for end in (facts.low, facts.high))
    counts = 'a solid' if solid and isinstance(shape, Mesh) else 'its hull'
    parts = (
        f'{file_name(shape)} from ({low}) to ({high}) m',
        f'{facts.num_triangles} triangles',
        'closed' if facts.is_closed else 'not closed',
        f'counts as {counts}',
        *facts.remarks,
    )
    return ', '.join(parts)


def _warning(facts: MeshFacts) -> str:
    """Return a warning about an unusual size of a mesh; empty if it is usual."""
    size = float((facts.high - facts.low).max())
    if size > LARGEST_PART:
        return (
            f'{size:.6g} m is its largest extent, above {LARGEST_PART:g} m. Is the file in '
            'millimetres? Lengths are metres, see scale'
        )
    if size < SMALLEST_PART:
        return (
            f'{size:.6g} m is its largest extent, below {SMALLEST_PART:g} m. Is it scaled, and '
            'its file in metres?'
        )
    return ''
