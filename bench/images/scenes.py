"""The scenes that images are timed of, by one script under the imports of either library."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bench.images import moderngl_side as images_moderngl
from drake_geom_ros.cross_check.bodies import Body
from truth.bodies import arms

WIDTH, HEIGHT, FOV_Y = 640, 480, 0.8
NEAR, FAR = 0.05, 20.0
FROM, AT = np.array([1.6, -1.4, 1.2]), np.array([0.0, 0.0, 0.3])


class Library(NamedTuple):
    """The modules of one import, and how its renderer is made."""

    geometry: Any
    math: Any
    sensors: Any
    renderer: Callable[[Any], Any]
    drawer: Callable[..., Any] | None = None  # draws our shapes without a query


def ours() -> Library:
    """Return what this package has."""
    names = ('geometry', 'math', 'sensors')
    modules = (importlib.import_module(f'drake_geom_ros.{name}') for name in names)
    return Library(*modules, lambda geometry: geometry.MakeRenderEngineExact())


def ours_by_vtk() -> Library | None:
    """Return what this package has, with VTK drawing; None where that cannot."""
    from drake_geom_ros.geometry.render.vtk.probing import why_not

    if reason := why_not():
        print(reason)
        return None
    return ours()._replace(renderer=lambda geometry: geometry.MakeRenderEngineVtk())


def pydrakes() -> Library | None:
    """Return what pydrake has, None where it is not installed."""
    if importlib.util.find_spec('pydrake') is None:
        print('pydrake is not installed: pip install drake')
        return None
    names = ('geometry', 'math', 'systems.sensors')
    modules = (importlib.import_module(f'pydrake.{name}') for name in names)

    def make(geometry: Any) -> Any:
        return geometry.MakeRenderEngineVtk(geometry.RenderEngineVtkParams())

    return Library(*modules, make)


def moderngls() -> Library | None:
    """Return a renderer of our shapes by OpenGL alone; None where that cannot."""
    if reason := images_moderngl.why_not():
        print(reason)
        return None
    return ours()._replace(drawer=images_moderngl.drawer)


LIBRARIES = {'exact': ours, 'VTK': ours_by_vtk, 'pydrake': pydrakes, 'moderngl': moderngls}


def shape_of(library: Library, body: Body) -> Any:
    """Return the shape of a body of the truth."""
    return getattr(library.geometry, body.kind)(*body.size)


def pose(library: Library, p: Any, R: Any = None) -> Any:
    """Return a pose of a library."""
    rotation = np.eye(3) if R is None else R
    return library.math.RigidTransform(library.math.RotationMatrix(rotation), p)


def arms_and_table(library: Library) -> list[tuple[Any, Any]]:
    """Return shapes and poses of two arms over a table with boxes."""
    bodies = [*arms.table(np.random.default_rng(0)), *arms.posed_links(arms.BENT)]
    return [(shape_of(library, body), pose(library, body.p, body.R)) for body in bodies]


def query_of(library: Library, bodies: list[tuple[Any, Any]]) -> Any:
    """Return a query object of a scene of anchored bodies, labelled by their places."""
    geometry = library.geometry
    scene = geometry.SceneGraph()
    source = scene.RegisterSource('bench')
    scene.AddRenderer('bench', library.renderer(geometry))
    for index, (shape, X) in enumerate(bodies):
        instance = geometry.GeometryInstance(X, shape, f'{index}')
        properties = geometry.PerceptionProperties()
        properties.AddProperty('label', 'id', geometry.RenderLabel(index % 30_000))
        instance.set_perception_properties(properties)
        scene.RegisterAnchoredGeometry(source, instance)
    context = scene.CreateDefaultContext()
    return scene.get_query_output_port().Eval(context), scene, context


def cameras(library: Library, width: int = WIDTH, height: int = HEIGHT) -> tuple[Any, Any]:
    """Return a colour and a depth camera."""
    geometry = library.geometry
    intrinsics = library.sensors.CameraInfo(width, height, FOV_Y)
    clipping = geometry.ClippingRange(NEAR / 2.0, 2.0 * FAR)
    core = geometry.RenderCameraCore('bench', intrinsics, clipping, pose(library, np.zeros(3)))
    depth_range = geometry.DepthRange(NEAR, FAR)
    return geometry.ColorRenderCamera(core), geometry.DepthRenderCamera(core, depth_range)


def looking(library: Library) -> Any:
    """Return X_WC of a camera that sees the table."""
    ahead = (AT - FROM) / np.linalg.norm(AT - FROM)
    aside = np.cross(ahead, [0.0, 0.0, 1.0])
    aside /= np.linalg.norm(aside)
    return pose(library, FROM, np.column_stack((aside, np.cross(ahead, aside), ahead)))


def balls(library: Library, count: int) -> list[tuple[Any, Any]]:
    """Return primitives of all kinds, as many in a room of one size: the more, the smaller."""
    random, geometry = np.random.default_rng(1), library.geometry
    size = 0.6 / count ** (1.0 / 3.0)
    made = []
    for k in range(count):
        a, b, c = size * random.uniform(0.2, 0.6, 3)
        shape = (
            *(geometry.Sphere(a), geometry.Box(a, b, c), geometry.Capsule(a / 2, b)),
            *(geometry.Cylinder(a / 2, b), geometry.Ellipsoid(a / 2, b / 2, c / 2)),
        )[k % 5]
        made.append((shape, pose(library, random.uniform([-1, -1, 0], [1, 1, 1]))))
    return made


def mesh(library: Library, count: int) -> list[tuple[Any, Any]]:
    """Return one wavy surface of about so many triangles."""
    n = max(int(np.sqrt(count / 2)), 1)
    x, y = np.meshgrid(*[np.linspace(-0.8, 0.8, n + 1)] * 2, indexing='ij')
    points = np.column_stack((x.ravel(), y.ravel(), 0.1 * np.sin(9 * x * y).ravel()))
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    first = np.column_stack((corner, corner + n + 1, corner + n + 2))
    second = np.column_stack((corner, corner + n + 2, corner + 1))
    shape = mesh_shape(library, points, np.concatenate((first, second)))
    return [(shape, pose(library, [0.0, 0.0, 0.3]))]


def mesh_shape(library: Library, points: Any, triangles: Any) -> Any:
    """Return a Mesh of points (n, 3) [m] and triangles (m, 3); pydrake takes them as an .obj."""
    geometry = library.geometry
    if hasattr(geometry, 'MeshData'):
        return geometry.Mesh.FromMeshData(geometry.MeshData(points, triangles))
    lines = [f'v {x:.9g} {y:.9g} {z:.9g}' for x, y, z in points.tolist()]
    # It wants normals; one will do for what is timed.
    lines += ['vn 0 0 1', *(f'f {a}//1 {b}//1 {c}//1' for a, b, c in (triangles + 1).tolist())]
    file = importlib.import_module('pydrake.common').MemoryFile(
        '\n'.join(lines).encode(), '.obj', 'mesh.obj'
    )
    return geometry.Mesh(geometry.InMemoryMesh(mesh_file=file), np.ones(3))
