"""Sections of ``check`` about contact surfaces with their meshes, and pairs of half spaces."""

from collections.abc import Iterator
from itertools import combinations

from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.geometry import GeometryId, HalfSpace, HydroelasticType, Role, VolumeMesh

_GROUP = 'hydroelastic'
_WORDS = {HydroelasticType.kRigid: 'rigid', HydroelasticType.kCompliant: 'compliant'}


def contact_lines(scene: OpenedScene) -> Iterator[str]:
    """Yield a line for each geometry with hydroelastic properties; nothing without any."""
    title = 'contact surfaces'
    geometries = scene.inspector.GetAllGeometryIds(Role.kProximity)
    for geometry in geometries:
        properties = scene.inspector.GetProximityProperties(geometry)
        assert properties is not None
        kind = properties.GetPropertyOrDefault(_GROUP, 'compliance_type', None)
        if kind in _WORDS:
            if title:
                yield title
            title = ''
            parts = [_WORDS[kind]]
            if kind is HydroelasticType.kCompliant:
                parts.append(f'{properties.GetProperty(_GROUP, "hydroelastic_modulus"):g} Pa')
            yield f'  {scene.names[geometry]}: {", ".join([*parts, _mesh(scene, geometry)])}'


def half_space_lines(scene: OpenedScene) -> Iterator[str]:
    """Yield a line for each pair of half spaces that is not filtered; nothing without any."""
    geometries = scene.inspector.GetAllGeometryIds(Role.kProximity)
    planes = [g for g in geometries if isinstance(scene.inspector.GetShape(g), HalfSpace)]
    manager = scene.scene_graph.collision_filter_manager()
    pairs = [(a, b) for a, b in combinations(planes, 2) if not manager.explain(a, b)]
    if pairs:
        yield 'pairs of half spaces'
    for a, b in pairs:
        yield (
            f'  {scene.names[a]} and {scene.names[b]}: in collision unless they are opposed and '
            'apart, without a distance, a depth or a contact surface; filter the pair'
        )


def _mesh(scene: OpenedScene, geometry: GeometryId) -> str:
    """Return a text about the hydroelastic mesh of a geometry."""
    if isinstance(scene.inspector.GetShape(geometry), HalfSpace):
        return 'half space'
    mesh = scene.inspector.maybe_get_hydroelastic_mesh(geometry)
    assert mesh is not None
    if isinstance(mesh, VolumeMesh):
        return f'{mesh.num_elements()} tetrahedra'
    return f'{mesh.num_triangles()} triangles'
