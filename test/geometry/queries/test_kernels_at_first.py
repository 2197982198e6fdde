"""The first query loads the kernels of all kinds that may meet, however far apart they are."""

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    CollisionFilterDeclaration,
    Cylinder,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry._proximity.engine import prepared
from drake_geom_ros.geometry._proximity.kernels.addresses import table_rows
from drake_geom_ros.math import RigidTransform

SHAPES = Sphere(0.1), Box(0.1, 0.2, 0.3), Cylinder(0.1, 0.2), Capsule(0.1, 0.2)


@pytest.fixture
def loaded(monkeypatch):
    """Return the rows whose kernels were loaded, of a process that has loaded none."""
    rows = []

    def compile_rows(wanted):
        rows.extend(np.asarray(wanted).tolist())
        return []

    monkeypatch.setattr(prepared, 'COMPILED_ROWS', np.zeros_like(prepared.COMPILED_ROWS))
    monkeypatch.setattr(prepared, 'compile_rows', compile_rows)
    return rows


@pytest.fixture
def scene():
    """Return a context of four bodies 10 m apart, its graph, ids of geometries, and types."""
    graph = SceneGraph()
    source = graph.RegisterSource('s')
    frames, ids = [], []
    for k, shape in enumerate(SHAPES):
        frames.append(graph.RegisterFrame(source, GeometryFrame(f'f{k}')))
        instance = GeometryInstance(RigidTransform(), shape, f'g{k}')
        ids.append(graph.RegisterGeometry(source, frames[-1], instance))
        graph.AssignRole(source, ids[-1], ProximityProperties())
    graph.collision_filter_manager().Apply(
        CollisionFilterDeclaration().ExcludeBetween(GeometrySet(ids[0]), GeometrySet(ids[1]))
    )
    context = graph.CreateDefaultContext()
    rows = np.array([[10.0 * k, 0, 0, 0, 0, 0, 1] for k in range(len(SHAPES))])
    context.UpdateFramePoses(FramePoseVector.FromArrays(frames, rows))
    types = context._state.up_to_date_world().geometries.types
    return graph, context, ids, types


def rows_of(types, *pairs):
    return {int(table_rows(types[[i]], types[[j]])[0]) for i, j in pairs}


def test_kinds_that_are_far_apart_are_loaded_and_those_that_are_filtered_are_not(scene, loaded):
    graph, context, ids, types = scene
    query = graph.get_query_output_port().Eval(context)
    assert len(query.ComputeSignedDistancePairwiseClosestPoints(0.1)) == 0
    meeting = rows_of(types, (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
    assert set(loaded) == meeting
    loaded.clear()
    graph.collision_filter_manager(context).Apply(
        CollisionFilterDeclaration().AllowBetween(GeometrySet(ids[0]), GeometrySet(ids[1]))
    )
    query = graph.get_query_output_port().Eval(context)
    query.ComputeSignedDistancePairwiseClosestPoints(0.1)
    assert set(loaded) == meeting | rows_of(types, (0, 1))


def test_what_needs_no_kernel_loads_none(scene, loaded):
    graph, context, _, _ = scene
    query = graph.get_query_output_port().Eval(context)
    query.FindCollisionCandidates()
    query.ComputeSignedDistancePairwiseClosestPoints(0.1, accuracy='bound')
    assert loaded == []
