"""What a checker leaves to the next one changes no answer, and is used only of the same scene."""

import math

import numpy as np
import pytest
from batch.test_paths import MOUNTED, ROD, same

from drake_geom_ros.batch import Joints, PathChecker, check_path
from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometryError,
    GeometrySet,
    SceneGraph,
)
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import load_scene

PATH = np.array([[0.0] * 6, [math.pi, 0.3, 0.5, 0.2, -0.4, 0.1]])


class Cell:
    """A robot on another one and one on a cart, of which a context is asked again and again."""

    def __init__(self, folder):
        (folder / 'rod.urdf').write_text(ROD)
        (folder / 'scene.yaml').write_text(MOUNTED)
        self.graph = SceneGraph()
        self.loaded = load_scene(folder / 'scene.yaml', self.graph)
        self.joints = Joints.of(self.loaded)
        self.context = self.graph.CreateDefaultContext()
        self.packed = 0

    def move_cart(self, y):
        cart = self.loaded.frames['posts', 'cart']
        pose = RigidTransform(RollPitchYaw(0, 0, 1), [0, y, 0])
        self.context.UpdateFramePoses(FramePoseVector({cart: pose}))

    def hold(self, path=PATH, joints=None, **asked):
        """Return what the context tells; it must be what one tells that nobody asked before."""
        joints, asked = joints or self.joints, {'ignore_limits': True, **asked}
        found = check_path(self.context, joints, path, threads=1, **asked)
        fresh = check_path(self.context.Clone(), joints, path, threads=1, **asked)
        assert same(found, fresh)
        return found


@pytest.fixture
def cell(tmp_path, monkeypatch):
    cell, honest = Cell(tmp_path), PackedScene.of

    def counted(context, *given, **more):
        cell.packed += context is cell.context
        return honest(context, *given, **more)

    monkeypatch.setattr(PackedScene, 'of', counted)
    return cell


def test_checks_of_the_same_scene_are_prepared_once(cell):
    first = cell.hold()
    assert first.outcome == 'contact'
    assert same(first, cell.hold())
    assert cell.hold(min_distance=0.05, ignore_start_contacts=True).times[0] <= first.times[0]
    cell.hold(PATH[:1])
    cell.hold(PATH[::-1], max_evaluations=3)
    assert same(first, cell.hold())
    assert cell.packed == 1


def test_whatever_else_an_answer_depends_on_is_another_kind(cell):
    away = cell.hold([[3.0] * 6, [3.1] * 6])
    cell.hold()
    assert cell.packed == 1
    cell.move_cart(3.0)  # the robot on it comes along
    there = cell.hold([[3.0] * 6, [3.1] * 6])
    assert there.lower_bound != away.lower_bound or there.outcome != away.outcome
    assert cell.packed == 2
    cell.hold(PATH[:, :2], Joints.of(cell.loaded, ['rod::turn', 'rod::push']))
    cell.hold(PATH[:, :2], Joints.of(cell.loaded, ['rod::turn', 'top::turn']))
    assert cell.packed == 4
    cell.hold(accuracy='fast')
    assert cell.packed == 5
    everything = GeometrySet(geometry_ids=list(cell.loaded.geometries.values())[:3])
    declaration = CollisionFilterDeclaration().ExcludeWithin(everything)
    cell.graph.collision_filter_manager(cell.context).Apply(declaration)
    cell.hold()
    assert cell.packed == 6


def test_who_has_what_is_prepared_has_it_alone(cell):
    one = PathChecker(cell.context, cell.joints, ignore_limits=True)
    with one, PathChecker(cell.context, cell.joints, ignore_limits=True) as other:
        assert cell.packed == 2
        assert same(one.check(PATH), other.check(PATH))
        assert all(same(one.check(PATH), each) for each in other.check_each([PATH] * 6, 3))
    for ended in (one, other):
        with pytest.raises(GeometryError, match='has ended'):
            ended.check(PATH)
    cell.hold()
    assert cell.packed == 2
