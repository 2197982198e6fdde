"""Two posed bodies with hydroelastic properties, in this package or in pydrake."""

from typing import NamedTuple

import numpy as np

import drake_geom_ros.geometry as ours
from drake_geom_ros.math import RigidTransform, RotationMatrix


class Body(NamedTuple):
    """A shape's name and arguments; ``modulus`` [Pa], 0 where rigid, None without properties."""

    kind: str
    sizes: tuple
    modulus: float | None
    hint: float = 0.3


def shape_of(geometry, body):
    if body.kind == 'Convex':
        return geometry.Convex(points=np.array(body.sizes).T, label='hull')
    if body.kind == 'Mesh':  # a box, of its corners and triangles
        return geometry.Mesh.FromMeshData(geometry.MeshData(*body.sizes))
    if body.kind == 'MeshFile':  # its path and scale
        return geometry.Mesh(*body.sizes)
    return getattr(geometry, body.kind)(*body.sizes)


def properties_of(geometry, body):
    properties = geometry.ProximityProperties()
    if body.modulus is None:
        return properties
    if body.modulus == 0.0:
        geometry.AddRigidHydroelasticProperties(body.hint, properties)
    elif body.kind == 'HalfSpace':
        geometry.AddCompliantHydroelasticPropertiesForHalfSpace(
            body.hint, body.modulus, properties
        )
    else:
        geometry.AddCompliantHydroelasticProperties(body.hint, body.modulus, properties)
    return properties


def transforms(geometry):
    """Return a function that makes poses of R (3, 3) and p (3,)."""
    if geometry is ours:
        return lambda R, p: RigidTransform(RotationMatrix(R), p)
    from pydrake import math

    return lambda R, p: math.RigidTransform(math.RotationMatrix(R), p)


def query_of(bodies, poses, geometry=ours, order=None):
    """Return a query object of bodies at poses (R, p), and their ids; registered in an order."""
    transform, scene = transforms(geometry), geometry.SceneGraph()
    source, ids = scene.RegisterSource('source'), {}
    vector = geometry.FramePoseVector()
    for k in order or range(len(bodies)):
        frame = scene.RegisterFrame(source, geometry.GeometryFrame(f'frame{k}'))
        shape = shape_of(geometry, bodies[k])
        instance = geometry.GeometryInstance(transform(np.eye(3), np.zeros(3)), shape, 'body')
        instance.set_proximity_properties(properties_of(geometry, bodies[k]))
        ids[k] = scene.RegisterGeometry(source, frame, instance)
        vector.set_value(frame, transform(*poses[k]))
    context = scene.CreateDefaultContext()
    scene.get_source_pose_port(source).FixValue(context, vector)
    query = scene.get_query_output_port().Eval(context)
    return query, [ids[k] for k in range(len(bodies))], (scene, context)


def surfaces(bodies, poses, geometry=ours, representation='kPolygon'):
    """Return the contact surfaces of bodies; those deep within one another have none."""
    # pydrake's query lives no longer than scene and context.
    query, _, _scene_and_context = query_of(bodies, poses, geometry)
    return query.ComputeContactSurfacesWithFallback(
        getattr(geometry.HydroelasticContactRepresentation, representation)
    )[0]
