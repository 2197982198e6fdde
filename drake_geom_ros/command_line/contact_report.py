"""The part of ``check`` that tells which geometries have contact surfaces, and of what meshes."""

from collections.abc import Iterator

from drake_geom_ros.command_line.posed_scene import PosedScene
from drake_geom_ros.geometry import GeometryId, HalfSpace, HydroelasticType, Role, VolumeMesh

_GROUP = 'hydroelastic'
_WORDS = {HydroelasticType.kRigid: 'rigid', HydroelasticType.kCompliant: 'compliant'}


def contact_lines(scene: PosedScene) -> Iterator[str]:
    """Yield a line for each geometry with hydroelastic properties; nothing without any."""
    title = 'contact surfaces'
    for geometry in scene.inspector.GetAllGeometryIds(Role.kProximity):
        properties = scene.inspector.GetProximityProperties(geometry)
        assert properties is not None
        kind = properties.GetPropertyOrDefault(_GROUP, 'compliance_type', None)
        if kind in _WORDS:
            if title:
                yield title
            title = ''
            told = [_WORDS[kind]]
            if kind is HydroelasticType.kCompliant:
                told.append(f'{properties.GetProperty(_GROUP, "hydroelastic_modulus"):g} Pa')
            yield f'  {scene.names[geometry]}: {", ".join([*told, _mesh(scene, geometry)])}'


def _mesh(scene: PosedScene, geometry: GeometryId) -> str:
    """Return what stands for a geometry, in words."""
    if isinstance(scene.inspector.GetShape(geometry), HalfSpace):
        return 'half space'
    mesh = scene.inspector.maybe_get_hydroelastic_mesh(geometry)
    assert mesh is not None
    if isinstance(mesh, VolumeMesh):
        return f'{mesh.num_elements()} tetrahedra'
    return f'{mesh.num_triangles()} triangles'
