"""Maps of which some cells change are the maps that one would have made whole."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    OccupiedCells,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensed_maps.cells import Cells, MapError

RESOLUTION = 0.1
keys = st.tuples(*3 * [st.integers(-4, 4)])
some_keys = st.sets(keys, max_size=12)
changes = st.lists(st.tuples(some_keys, some_keys), min_size=1, max_size=5)


def cells_of(of_keys):
    return Cells.of_keys(np.array(sorted(of_keys), dtype=np.int64).reshape(-1, 3), RESOLUTION)


class Scene:
    """A ball that goes about, and a map."""

    def __init__(self, shape):
        self.graph = SceneGraph()
        self.source = self.graph.RegisterSource('test')
        self.hand = self.graph.RegisterFrame(self.source, GeometryFrame('hand'))
        ball = self._instance(Sphere(0.07), 'ball')
        self.graph.RegisterGeometry(self.source, self.hand, ball)
        seen = self._instance(shape, 'map')
        self.map = self.graph.RegisterAnchoredGeometry(self.source, seen)
        self.context = self.graph.CreateDefaultContext()

    def _instance(self, shape, name):
        instance = GeometryInstance(RigidTransform(), shape, name)
        instance.set_proximity_properties(ProximityProperties())
        return instance

    def put(self, shape):
        self.graph.ChangeShape(self.context, self.source, self.map, shape)

    def answers(self, p_WH):
        self.context.UpdateFramePoses(FramePoseVector({self.hand: RigidTransform(p_WH)}))
        query = self.graph.get_query_output_port().Eval(self.context)
        pair = query.ComputeSignedDistancePairwiseClosestPoints()
        point = query.ComputeSignedDistanceToPoint(np.add(p_WH, 0.3))
        fields = 'distance', 'error_bound', 'nhat_BA_W', 'p_WCa', 'p_WCb', 'is_nhat_BA_W_unique'
        told = [getattr(pair, name).tolist() for name in fields]
        return told, sorted(point.distance.tolist()), query.HasCollisions()


@settings(max_examples=60, deadline=None)
@given(st.sets(keys, min_size=1, max_size=30), changes, st.integers(0, 2**32 - 1))
def test_a_map_changed_cell_by_cell_answers_as_one_made_whole(first, steps, seed):
    """To the bit, and whatever was asked before."""
    rng = np.random.default_rng(seed)
    held, cells = set(first), cells_of(first)
    scene = Scene(OccupiedCells(RESOLUTION, cells.centres()))
    for added, gone in steps:
        gone = gone & held
        if not (held - gone) | added:
            continue
        scene.answers(rng.uniform(-0.6, 0.6, 3))
        held = (held - gone) | added
        cells = cells.changed(cells_of(added), cells_of(gone))
        whole = cells_of(held)
        assert cells.packed.tolist() == whole.packed.tolist()
        scene.put(OccupiedCells(RESOLUTION, cells.centres()))
        fresh = Scene(OccupiedCells(RESOLUTION, rng.permutation(whole.centres())))
        for p_WH in rng.uniform(-0.6, 0.6, (4, 3)):
            assert scene.answers(p_WH) == fresh.answers(p_WH)


def test_a_change_that_cannot_be_leaves_the_map():
    cells = cells_of([(0, 0, 0), (1, 0, 0)])
    before = cells.packed.tolist()
    with pytest.raises(MapError, match=r'1 of 2 cells to remove .* \[0\.55, 0\.05, 0\.05\] m'):
        cells.changed(removed=cells_of([(1, 0, 0), (5, 0, 0)]))
    other = Cells.of_keys(np.zeros((1, 3), dtype=np.int64), 0.2)
    for which in ('added', 'removed'):
        with pytest.raises(MapError, match=f'{which} cells have a resolution of 0.2 m'):
            cells.changed(**{which: other})
    assert cells.packed.tolist() == before
    assert cells.changed().packed.tolist() == before


def test_what_is_removed_and_added_is_there():
    cells = cells_of([(0, 0, 0), (1, 0, 0)])
    same = cells_of([(1, 0, 0)])
    assert cells.changed(added=same, removed=same).packed.tolist() == cells.packed.tolist()
    assert cells.changed(added=same).packed.tolist() == cells.packed.tolist()
    assert cells.changed(removed=cells).packed.tolist() == []
