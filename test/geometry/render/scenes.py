"""Scenes and cameras for images."""

import numpy as np

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    GeometryInstance,
    HalfSpace,
    MakeRenderEngineExact,
    Mesh,
    MeshData,
    PerceptionProperties,
    RenderEngineExactParams,
    RenderLabel,
    Rgba,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix

NAME = 'exact'


def properties(label=None, colour=None):
    made = PerceptionProperties()
    if label is not None:
        made.AddProperty('label', 'id', RenderLabel(label))
    if colour is not None:
        made.AddProperty('phong', 'diffuse', Rgba(*colour))
    return made


def shape_of(shape):
    """Return a shape; (vertices, triangles) is a mesh."""
    return Mesh.FromMeshData(MeshData(*shape)) if isinstance(shape, tuple) else shape


def instance(shape, X_PG, name='it', made=None):
    geometry = GeometryInstance(X_PG, shape_of(shape), name)
    geometry.set_perception_properties(properties() if made is None else made)
    return geometry


def scene_of(bodies, **params):
    """Return a scene of anchored (shape, X_WG), labelled by their places, and its source."""
    scene = SceneGraph()
    source = scene.RegisterSource('it')
    scene.AddRenderer(NAME, MakeRenderEngineExact(RenderEngineExactParams(**params)))
    for index, (shape, X_WG) in enumerate(bodies):
        geometry = instance(shape, X_WG, f'{index}', properties(index))
        scene.RegisterAnchoredGeometry(source, geometry)
    return scene, source


def query_of(scene):
    return scene.get_query_output_port().Eval(scene.CreateDefaultContext())


def images(scene, camera, X_WC=None, want=('color', 'depth', 'label')):
    pose = RigidTransform() if X_WC is None else X_WC
    return query_of(scene).render_images(camera, scene.world_frame_id(), pose, want)


def slopes(core, u, v):
    """Return the slopes (x, y) of the ray of a pixel, as technology_choices.md has them."""
    k = core.intrinsics()
    return (u + 0.5 - k.center_x()) / k.focal_x(), (v + 0.5 - k.center_y()) / k.focal_y()


def random_pose(random, reach):
    angles = random.uniform(-np.pi, np.pi, 3)
    return RigidTransform(RollPitchYaw(angles), random.uniform(-reach, reach, 3))


def random_shape(random, kind, size=1.0):
    a, b, c = size * random.uniform(0.1, 0.5, 3)
    made = {
        'sphere': lambda: Sphere(a),
        'box': lambda: Box(2 * a, 2 * b, 2 * c),
        'capsule': lambda: Capsule(a, 2 * b),
        'cylinder': lambda: Cylinder(a, 2 * b),
        'ellipsoid': lambda: Ellipsoid(a, b, c),
        'half_space': HalfSpace,
        'mesh': lambda: tetrahedra(random, size),
    }
    return made[kind]()


KINDS = ('sphere', 'box', 'capsule', 'cylinder', 'ellipsoid', 'half_space', 'mesh')


def tetrahedra(random, size):
    """Return vertices and triangles of three tetrahedra."""
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    return (
        random.uniform(-0.5, 0.5, (12, 3)) * size,
        np.concatenate([faces, faces + 4, faces + 8]),
    )


def looking(from_W, at_W):
    """Return X_WC of a camera that looks from one point at another, x level."""
    ahead = np.subtract(at_W, from_W) / np.linalg.norm(np.subtract(at_W, from_W))
    aside = np.cross(ahead, [0.0, 0.0, 1.0] if abs(ahead[2]) < 0.9 else [0.0, 1.0, 0.0])
    aside /= np.linalg.norm(aside)
    R = RotationMatrix(np.column_stack((aside, np.cross(ahead, aside), ahead)))
    return RigidTransform(R, from_W)
