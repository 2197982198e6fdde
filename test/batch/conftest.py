"""A robot among obstacles, of every kind of shape, and random states of it."""

from pathlib import Path

import numpy as np
import pytest

from drake_geom_ros.batch import Joints
from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometrySet,
    SceneGraph,
)
from drake_geom_ros.scene_files import load_scene


class Cell:
    """A loaded scene, its joints, and questions to a context that never saw another state."""

    path = Path(__file__).with_name('cell.yaml')

    def __init__(self):
        self.scene_graph = SceneGraph()
        self.loaded = load_scene(self.path, self.scene_graph)
        self.joints = Joints.of(self.loaded)

    def states(self, count, seed=1):
        lower, upper = self.joints.lower.clip(-3), self.joints.upper.clip(max=3)
        return np.random.default_rng(seed).uniform(lower, upper, (count, self.joints.count))

    def fresh(self, poses):
        """Return a query object of a new context with the arm at poses (n, 7)."""
        context = self.scene_graph.CreateDefaultContext()
        context.UpdateFramePoses(FramePoseVector.FromArrays(self.joints.frame_ids, poses))
        return self.scene_graph.get_query_output_port().Eval(context)

    def each(self, states):
        """Yield a fresh query object for each of some states."""
        for poses in self.joints.poses(states):
            yield self.fresh(poses)


@pytest.fixture(scope='session')
def cell():
    return Cell()


def cell_off_the_floor():
    """Return a new cell, in which the arm's base touches the floor and nobody counts it."""
    cell = Cell()
    base = GeometrySet(frame_ids=[cell.loaded.frames['arm', 'base']])
    floor = GeometrySet(geometry_ids=[cell.loaded.geometries['things', 'world', 'floor']])
    declaration = CollisionFilterDeclaration().ExcludeBetween(base, floor)
    cell.scene_graph.collision_filter_manager().Apply(declaration)
    return cell
