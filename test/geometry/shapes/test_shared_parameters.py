"""A large shape is in memory once: its parameters are those of the tables that queries read."""

import gc
import threading
import weakref

import numpy as np
import pytest
import trimesh
from numba import config

from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    Mesh,
    MeshData,
    OccupiedCells,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.queries.world_tables import pooled
from drake_geom_ros.geometry.shapes import primitives
from drake_geom_ros.geometry.shapes.primitives import PackedShape, for_queries
from drake_geom_ros.math import RigidTransform

CELLS = np.stack(np.meshgrid(*[np.arange(24.0)] * 3), axis=-1).reshape(-1, 3)


def cells():
    return OccupiedCells(1.0, CELLS)


def solid():
    ball = trimesh.creation.icosphere(subdivisions=4)
    vertices = np.array(ball.vertices)
    bumpy = vertices * (1.0 + 0.2 * np.sin(5.0 * vertices[:, :1]))
    return Mesh.FromMeshData(MeshData(bumpy, np.array(ball.faces)))


class Scene:
    """A large shape and a ball on a frame."""

    def __init__(self, shape, is_solid):
        self.graph = SceneGraph()
        self.source = self.graph.RegisterSource('test')
        self.large = self.add(shape, 'large', solid=is_solid)
        self.frame = self.graph.RegisterFrame(self.source, GeometryFrame('ball'))
        self.add(Sphere(0.3), 'ball', self.frame)
        self.context = self.graph.CreateSharedContext()
        self.query = self.graph.get_query_output_port().Eval(self.context)

    def add(self, shape, name, frame=None, solid=False):
        properties = ProximityProperties()
        if solid:
            properties.AddProperty('mesh', 'solid', True)
        instance = GeometryInstance(RigidTransform(), shape, name)
        instance.set_proximity_properties(properties)
        frame = frame or self.graph.world_frame_id()
        return self.graph.RegisterGeometry(self.source, frame, instance)

    def distances(self):
        pose = RigidTransform([-3.0, 0.2, 0.1])
        self.context.UpdateFramePoses(FramePoseVector({self.frame: pose}))
        return self.query.ComputeSignedDistancePairwiseClosestPoints().distance.tolist()


@pytest.mark.parametrize(('make', 'is_solid'), [(cells, False), (solid, True)])
def test_the_parameters_of_a_large_shape_are_those_of_the_tables(make, is_solid):
    shape = make()
    packed = for_queries(shape, is_solid).in_pairs
    values, alone = packed.parameters.copy(), weakref.ref(packed.parameters)
    scene = Scene(shape, is_solid)
    before = scene.distances()
    pool = scene.query._state.world.geometries.pool
    assert np.shares_memory(packed.parameters, pool)
    np.testing.assert_array_equal(packed.parameters, values)
    gc.collect()
    assert alone() is None  # it was there once more
    for k in range(9):  # rows are kept, then all are made again
        scene.add(Sphere(0.1), f'ball {k}')
        assert scene.distances()[: len(before)] == before
    tables = scene.query._state.world.geometries
    assert np.shares_memory(packed.parameters, tables.pool)
    assert not np.shares_memory(packed.parameters, pool)
    with pytest.raises(ValueError, match='read-only'):
        packed.parameters[0] = 0.0


def test_another_shape_of_one_mesh_shares_them_too():
    shape = solid()
    packed = for_queries(shape, True).in_pairs
    scene = Scene(shape, True)
    first = scene.distances()
    again = Mesh.FromMeshData(MeshData(*shape.surface()))
    assert for_queries(again, True).in_pairs is packed
    assert Scene(again, True).distances() == first


def test_a_shape_that_fills_little_of_a_pool_keeps_its_own():
    shape = OccupiedCells(1.0, CELLS[:2000])
    packed = for_queries(shape).in_pairs
    scene = Scene(shape, False)
    scene.add(cells(), 'more')
    scene.distances()
    assert not np.shares_memory(packed.parameters, scene.query._state.world.geometries.pool)


@pytest.mark.skipif(config.DISABLE_JIT, reason='the coverage of mutants holds what is resized')
@pytest.mark.parametrize('place', [0, 1, 2])
@pytest.mark.parametrize('make', [cells, solid])
def test_a_pool_is_made_in_the_memory_of_its_largest_shape(make, place):
    large = for_queries(make(), True).in_pairs
    values, small = large.parameters.copy(), for_queries(Sphere(0.3)).in_pairs
    own = PackedShape(large.kind, values.copy())
    packed = [small, small]
    packed.insert(place, own)
    types, starts, pool = pooled(packed)
    assert np.shares_memory(own.parameters, pool)
    assert not own.parameters.flags.writeable
    np.testing.assert_array_equal(own.parameters, values)
    expected = pooled([small if each is small else large for each in packed])
    for one, other in zip((types, starts, pool), expected, strict=True):
        np.testing.assert_array_equal(one, other)


def test_parameters_that_somebody_holds_are_copied():
    values = for_queries(cells()).in_pairs.parameters.copy()
    held = values[1:]
    packed = PackedShape(1, values)
    small = for_queries(Sphere(0.3)).in_pairs
    _, starts, pool = pooled([small, packed])
    assert not np.shares_memory(pool, held)
    np.testing.assert_array_equal(pool[starts[1] : starts[2]][1:], held)
    np.testing.assert_array_equal(packed.parameters[1:], held)


def test_who_reads_parameters_while_they_move_waits():
    packed = PackedShape(1, np.arange(1e5))
    reading = threading.Event()
    read = []

    def reader():
        reading.set()
        read.append(packed.parameters)

    thread = threading.Thread(target=reader)
    with primitives._moving:
        packed._parameters = None
        thread.start()
        reading.wait()
        packed._parameters = np.arange(1e5)
    thread.join()
    np.testing.assert_array_equal(read[0], np.arange(1e5))


def test_where_there_is_no_memory_a_shape_keeps_its_parameters():
    shape = PackedShape(1, np.arange(5.0))
    assert shape.grown(0, 1 << 45) is None
    assert shape.parameters.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert not shape.parameters.flags.writeable
