"""Witness points and normals that a node said are judged: true ones pass, false ones do not."""

from types import SimpleNamespace

import numpy as np
import pytest

from drake_geom_ros.geometry import FramePoseVector, GeometryId, SceneGraph
from drake_geom_ros.recordings.message_types import DISTANCES, OVERLAPS
from drake_geom_ros.recordings.recorded_pairs import (
    Outcome,
    compare,
    computed_pairs,
    of_event_points,
    recorded_pairs,
)
from drake_geom_ros.scene_files import load_scene

SCENE = """
sources: [s]
frames:
{frames}
geometries:
- {{name: floor, source: s, shape: {{type: half_space}}}}
{shapes}
"""
SHAPES = (
    '{type: sphere, radius: 0.3}',
    '{type: box, size: [0.4, 0.6, 0.2]}',
    '{type: cylinder, radius: 0.2, length: 0.6}',
    '{type: capsule, radius: 0.15, length: 0.5}',
    '{type: ellipsoid, semi_axes: [0.2, 0.3, 0.4]}',
    '{type: convex, uri: angle.obj}',
    '{type: mesh, uri: angle.obj}',
    '{type: mesh, uri: angle.obj, scale: 0.7}',
    '{type: mesh, uri: angle.obj}, roles: {proximity: {mesh: {solid: true}}}',
)
CORNERS = [(0, 0), (0.6, 0), (0.6, 0.2), (0.2, 0.2), (0.2, 0.6), (0, 0.6)]  # of an angle


def angle():
    """Return a solid that is not convex, as an OBJ."""
    lines = [f'v {x} {y} {z}' for z in (0, 0.3) for x, y in CORNERS]
    faces = [(4, 3, 2, 1), (6, 5, 4, 1), (7, 8, 9, 10), (7, 10, 11, 12)]
    faces += [(k + 1, (k + 1) % 6 + 1, (k + 1) % 6 + 7, k + 7) for k in range(6)]
    return '\n'.join([*lines, *(f'f {" ".join(map(str, face))}' for face in faces)])


def query_of(folder, seed):
    """Return a query object of shapes that stand anywhere, and their names by id."""
    rng, count = np.random.default_rng(seed), len(SHAPES)
    (folder / 'angle.obj').write_text(angle())
    frames = ''.join(f'- {{name: f{k}, source: s}}\n' for k in range(len(SHAPES)))
    shapes = ''.join(
        f'- {{name: g{k}, source: s, frame: f{k}, shape: {shape}}}\n'
        for k, shape in enumerate(SHAPES)
    )
    graph = SceneGraph()
    (folder / 'scene.yaml').write_text(SCENE.format(frames=frames, shapes=shapes))
    loaded = load_scene(folder / 'scene.yaml', graph)
    rows = np.hstack((rng.uniform(-0.6, 0.6, (count, 3)), rng.normal(size=(count, 4))))
    rows[:, 3:] /= np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)
    if seed == 0:  # flush sides: of many points any may be told
        rows[:, 3:], rows[1, :3] = (0, 0, 0, 1), (0, 0, 0.1)
    context = graph.CreateSharedContext()
    ids = [loaded.frames['s', f'f{k}'] for k in range(len(SHAPES))]
    context.UpdateFramePoses(FramePoseVector.FromArrays(ids, rows))
    names = {id.get_value(): '::'.join(name) for name, id in loaded.geometries.items()}
    return graph.get_query_output_port().Eval(context), names


def said_of(kind, query, accuracy):
    """Return what a node would say at a level of accuracy."""
    found = query.ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)
    common = {'waiting_pairs': 0, 'max_distance': np.inf}
    if kind == OVERLAPS:
        found = query.ComputePointPairPenetration(accuracy=accuracy)
        points = {'p_wca': found.p_WCa.ravel().copy(), 'p_wcb': found.p_WCb.ravel().copy()}
        common['depth'] = found.depth
    else:
        points = {'p_aca': found.p_ACa.ravel().copy(), 'p_bcb': found.p_BCb.ravel().copy()}
        common['distance'] = found.distance
    return SimpleNamespace(
        id_a=found.id_A,
        id_b=found.id_B,
        nhat_ba_w=found.nhat_BA_W.ravel().copy(),
        error_bound=found.error_bound,
        method=found.method,
        **points,
        **common,
    )


def outcome(kind, said, query, names):
    pairs = recorded_pairs(kind, said, names)
    now = computed_pairs(kind, query, names, 0, pairs.reach)
    return compare(pairs, now, query, names)


@pytest.mark.parametrize('kind', [DISTANCES, OVERLAPS])
@pytest.mark.parametrize('seed', range(8))
def test_what_is_true_is_never_refuted(tmp_path, kind, seed):
    query, names = query_of(tmp_path, seed)
    assert outcome(kind, said_of(kind, query, 'exact'), query, names).outcome == Outcome.SAME
    for accuracy in ('fast', 'bound'):
        found = outcome(kind, said_of(kind, query, accuracy), query, names)
        assert found.outcome in (Outcome.SAME, Outcome.WITHIN), (accuracy, found)


@pytest.mark.parametrize('kind', [DISTANCES, OVERLAPS])
@pytest.mark.parametrize('seed', range(4))
def test_what_is_false_is_refuted(tmp_path, kind, seed):
    query, names = query_of(tmp_path, seed)
    rng = np.random.default_rng(seed)
    fields = ('p_aca', 'p_bcb') if kind == DISTANCES else ('p_wca', 'p_wcb')
    # Of overlapping solids the bound may be centimetres, and so may be what is off.
    sharp = np.flatnonzero(said_of(kind, query, 'exact').error_bound < 1e-6)
    assert sharp.size
    for field in (*fields, 'nhat_ba_w'):
        for _ in range(10):
            said = said_of(kind, query, 'exact')
            k = 3 * rng.choice(sharp)
            step = rng.normal(size=3)
            getattr(said, field)[k : k + 3] += 0.01 * step / np.linalg.norm(step)
            found = outcome(kind, said, query, names)
            assert found.outcome == Outcome.REFUTED, (field, k)
        for value in (np.nan, np.inf, 0.0):
            said = said_of(kind, query, 'exact')
            getattr(said, field)[3 * sharp[0] : 3 * sharp[0] + 3] = value
            assert outcome(kind, said, query, names).outcome == Outcome.REFUTED
    said = said_of(kind, query, 'exact')
    said.nhat_ba_w[3 * sharp[0] : 3 * sharp[0] + 3] *= -1.0
    assert outcome(kind, said, query, names).outcome == Outcome.REFUTED


def test_other_points_of_flush_sides_are_true(tmp_path):
    query, names = query_of(tmp_path, 0)
    said = said_of(DISTANCES, query, 'exact')
    names_of = [names[i] + names[j] for i, j in zip(said.id_a, said.id_b, strict=True)]
    (k,) = (n for n, both in enumerate(names_of) if 'floor' in both and 'g1' in both)
    for points in (said.p_aca, said.p_bcb):
        points[3 * k : 3 * k + 2] += 0.05  # the box and the floor are told on the same spot
    assert outcome(DISTANCES, said, query, names).outcome == Outcome.WITHIN


@pytest.mark.parametrize('seed', range(4))
def test_points_of_events_are_judged(tmp_path, seed):
    query, _ = query_of(tmp_path, seed)
    rng = np.random.default_rng(seed)
    told = query.ComputeSignedDistancePairwiseClosestPoints()
    for k, both in enumerate(zip(told.id_A.tolist(), told.id_B.tolist(), strict=True)):
        if told.error_bound[k] > 1e-6:
            continue
        a, b = map(GeometryId, both)
        now = query.signed_distance_of_pair(a, b)
        assert now.id_A[0] in both
        points = np.vstack((now.p_WCa, now.p_WCb))[:: 1 if now.id_A[0] == both[0] else -1]
        event = SimpleNamespace(
            points=points, distance=float(now.distance[0]), error_bound=float(now.error_bound[0])
        )

        def judged(event=event, now=now, pair=(a, b)):
            return of_event_points(event, now, query, pair, is_same=True).outcome

        assert judged() == Outcome.SAME
        step = rng.normal(size=3)
        for wrong in (0.01 * step / np.linalg.norm(step), np.nan):
            event.points = points + np.vstack((np.zeros(3), np.broadcast_to(wrong, 3)))
            assert judged() == Outcome.REFUTED
        event.points = None  # of a message that has none
        assert judged() == Outcome.SAME
