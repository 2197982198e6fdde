"""What comes close to a body stays near it for rules, though no map holds its points."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.conversions.test_depth_image import camera, image
from live.inputs.sensing_node import Node, cloud, header

from drake_geom_ros.geometry import ProximityProperties, RoleAssign
from drake_geom_ros.live.inputs.point_taker import PointTaker
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.services.obstacles import clear_obstacles
from drake_geom_ros.proximity_rules import ProximityRule

# A forearm, and a camera that looks down on it from aside.
SCENE = """
sources: [s]
frames:
- {name: arm, source: s}
- {name: mast, source: s, pose: {position: [0.6, 0, 2]}, static: true}
geometries:
- {name: forearm, source: s, frame: arm, shape: {type: cylinder, radius: 0.05, length: 0.6}}
"""
STEP = 0.125  # [s] between two messages, a number without rounding
MAST = np.array([0.6, 0.0, 2.0])
GRID = np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 26)] * 2), axis=-1).reshape(-1, 2)
WALL = np.concatenate([np.full((len(GRID), 1), 1.32), GRID], axis=1)
APPROACH = [0.06, 0.05, 0.04, 0.03, 0.02, 0.0, -0.05]  # [m] gaps


def ball(gap, radius=0.01):
    """Return points of a ball beside the forearm."""
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, np.newaxis]
    return radius * directions + [0.05 + gap + radius, 0.0, 0.0]


class Watched:
    """A node whose rule stops the arm 5 cm before an obstacle."""

    def __init__(self, enter=0.05, leave=0.1, set_b='obstacles', **changes):
        usual = {'resolution': 0.03, 'self_filter': 'scene'}
        self.node = Node(scene=SCENE, **{**usual, **changes})
        self.node.move(100.0, [0.0, 0.0, 0.0])
        self.stamp = 100.0
        rule = ProximityRule('hands off', ('forearm',), (set_b,), enter=enter, leave=leave)
        with self.node.live.editing() as scene:
            scene.bind_rules()
            scene.rules.add([rule])

    def see(self, *parts, frame='mast'):
        """Take a cloud of points in the world, some time after the one before."""
        self.stamp += STEP
        self.node.clock.now = self.stamp
        self.node.move(self.stamp, [0.0, 0.0, 0.0])
        points = np.concatenate(parts) - (MAST if frame == 'mast' else 0.0)
        self.node.taker.take_cloud(cloud(points, frame, self.stamp))

    def decide(self):
        """Return the state of the rule by the poses of now, and the scale of speed."""
        with self.node.live.editing() as scene:
            scene.bind_rules()
            rules = scene.rules
            blind = scene.poses.blind_frames(1.0)
            rules.decide(
                self.stamp,
                scene.query,
                blind,
                shells=scene.maps.shells(),
                sights=scene.maps.sights(),
            )
            (state,) = rules.states()
            return state, rules.speed_scale()


def test_a_ball_that_comes_close_stays_near_until_it_is_in_the_arm():
    watched = Watched()
    told = []
    for gap in APPROACH:
        watched.see(ball(gap), WALL)
        state, scale = watched.decide()
        told.append((gap, state.is_entered, scale))
        assert state.lowest <= gap + 0.001 or gap < 0.0
    assert told == [(gap, True, 0.0) for gap in APPROACH]


def test_a_wall_that_reaches_into_the_arm_is_near():
    watched = Watched()
    watched.see(WALL - [1.32, 0.0, 0.0], WALL)
    state, scale = watched.decide()
    assert (state.is_entered, scale) == (True, 0.0)
    assert state.lowest < 0.02  # what is in the arm nobody can tell from the arm


def test_the_surface_of_the_arm_itself_is_no_obstacle_within_the_noise():
    watched = Watched()
    turns = np.linspace(0.0, 2.0 * np.pi, 60)
    for off in (-0.03, 0.0, 0.009):
        x, y = (0.05 + off) * np.cos(turns), (0.05 + off) * np.sin(turns)
        watched.see(np.stack([x, y, np.zeros(60)], axis=1), WALL)
        state, scale = watched.decide()
        assert (state.is_entered, scale) == (False, 1.0)
        assert watched.node.input.counts.in_shell == 0
        assert watched.node.live.view().reservations() == ''


def test_what_vanished_beside_a_body_stays_until_the_sensor_looks_past_it():
    watched = Watched()
    watched.see(ball(0.03), WALL)
    watched.see(WALL)
    assert watched.decide()[0].is_entered
    behind = MAST + 1.6 * (ball(0.03) - MAST)
    watched.see(WALL, behind)
    state, scale = watched.decide()
    assert (state.is_entered, scale) == (False, 1.0)


def test_rays_that_end_on_the_body_behind_free_a_place_before_it():
    watched = Watched()
    watched.see(ball(0.04), WALL)
    assert watched.decide()[0].is_entered
    ways = ball(0.04) - MAST
    rays = ways / np.linalg.norm(ways, axis=1)[:, np.newaxis]
    on_arm = MAST + rays * ((0.05 - MAST[0]) / rays[:, 0])[:, np.newaxis]  # where it faces them
    watched.see(on_arm, WALL)
    assert watched.node.input.counts.on_bodies == len(on_arm)
    assert not watched.decide()[0].is_entered


def test_a_cell_of_the_map_stays_where_the_arm_came_too_near_to_see_it():
    watched = Watched()
    watched.see(ball(0.2, radius=0.004), WALL)
    assert not watched.decide()[0].is_entered
    node = watched.node
    watched.stamp += STEP
    node.clock.now = watched.stamp
    node.move(watched.stamp, [0.2, 0.0, 0.0])  # until it touches the ball
    points = np.concatenate([ball(0.2, radius=0.004), WALL]) - MAST
    node.taker.take_cloud(cloud(points, 'mast', watched.stamp))
    assert node.input.counts.on_bodies == 200  # all of the ball
    state, scale = watched.decide()
    assert (state.is_entered, scale) == (True, 0.0)


def test_a_place_is_held_no_longer_than_keep_or_once_the_arm_has_left_it():
    for changes, steps in (({'keep': 0.25}, 3), ({}, 1)):
        watched = Watched(**changes)
        watched.see(ball(0.0), WALL)
        for k in range(steps):
            assert watched.decide()[0].is_entered, k
            watched.see(WALL)
        if changes:
            assert not watched.decide()[0].is_entered
            continue
        assert watched.decide()[0].is_entered
        watched.node.move(watched.stamp + STEP, [-0.5, 0.0, 0.0])
        points = WALL - MAST
        watched.node.clock.now = watched.stamp = watched.stamp + STEP
        watched.node.taker.take_cloud(cloud(points, 'mast', watched.stamp))
        assert not watched.decide()[0].is_entered
        assert watched.node.input.counts.shell_cells == 0


def test_a_cloud_in_the_frame_of_the_world_frees_nothing_for_no_sensor_is_at_its_origin():
    watched = Watched()
    watched.see(ball(0.03), WALL, frame='world')
    watched.see(WALL, 2.0 * ball(0.03), frame='world')
    assert watched.decide()[0].is_entered


def test_a_process_of_sensors_that_starts_anew_goes_on_holding():
    watched = Watched()
    watched.see(ball(0.0), WALL)
    watched.node.taker = PointTaker(watched.node.input)
    watched.see(WALL)
    assert watched.decide()[0].is_entered


def test_a_map_that_was_cleared_holds_nothing_beside_bodies():
    watched = Watched()
    watched.see(ball(0.02), WALL)
    clear_obstacles(watched.node.live, Plain(map=''), Plain())
    watched.see(WALL)
    assert watched.node.input.counts.shell_cells == 0
    assert not watched.decide()[0].is_entered


def test_a_cloud_all_of_which_is_beside_bodies_makes_the_map():
    watched = Watched()
    watched.see(ball(0.02))
    assert len(watched.node.centres())
    assert watched.decide()[0].is_entered


def test_few_points_of_a_cell_count_together_where_the_shell_ends_in_it():
    watched = Watched(least_points=4)
    sides = [[0.095, 0.002, 0.002], [0.096, 0.002, 0.002]]  # 45 and 46 mm off
    beyond = [[0.104, 0.002, 0.002], [0.105, 0.002, 0.002]]
    watched.see(np.array(sides + beyond), np.repeat(WALL, 4, axis=0))
    counts = watched.node.input.counts
    assert (counts.in_shell, counts.shell_cells, counts.in_sparse_cells) == (2, 1, 0)


def test_a_depth_image_shows_what_is_beside_bodies_as_a_cloud_does():
    watched = Watched()
    watched.node.move(watched.stamp, [0.0, 0.0, 0.0])
    info, depths = camera(2, 1), image([[0.32, 4.0]])  # 2 cm above the end of the forearm
    info.header = depths.header = header('world', watched.stamp)
    watched.node.taker.take_camera(info)
    watched.node.taker.take_depth(depths)
    assert watched.node.input.counts.in_shell == 1
    assert watched.decide()[0].is_entered


def test_answers_say_how_many_points_are_beside_bodies_and_how_near():
    watched = Watched()
    watched.see(ball(0.02), WALL)
    view = watched.node.live.view()
    message = Plain()
    view.waiting().tell_pairs(message)
    assert message.shell_points == 200
    assert message.least_shell_distance == pytest.approx(0.02, abs=1e-4)
    assert '200 points of sensors are beside bodies, the nearest 0.02' in view.reservations()


def test_a_padding_of_the_body_makes_its_own_surface_no_thicker():
    watched = Watched()
    with watched.node.live.editing() as scene:
        geometry = scene.model.names.geometry('arm/forearm')
        padded = ProximityProperties()
        padded.AddProperty('proximity', 'padding', 0.2)
        source = scene.model.inspector.GetOwningSourceId(geometry)
        scene.make(
            Change(
                lambda graph, _: graph.AssignRole(source, geometry, padded, RoleAssign.kReplace)
            )
        )
    watched.see(ball(0.15), WALL)
    assert watched.node.input.counts.on_bodies == 0
    state, _ = watched.decide()
    assert state.is_entered
    assert state.lowest < 0.0


@pytest.mark.parametrize('name', ['obstacles', 'points', 'points/map', 'obstacles::points/map'])
def test_a_rule_watches_what_is_beside_bodies_by_every_name_of_the_map(name):
    watched = Watched(set_b=name)
    watched.see(ball(0.0), WALL)
    assert watched.decide()[0].is_entered


def test_a_rule_that_asks_for_less_than_a_map_can_tell_is_named_with_the_limit():
    for enter, changes, limit in (
        (0.05, {}, ''),
        (0.049, {}, '0.05 m'),
        (0.03, {'padding': 0.02}, ''),
        (0.029, {'padding': 0.02}, '0.03 m'),
        (0.03, {'self_filter': 'none'}, ''),
    ):
        watched = Watched(enter=enter, **changes)
        settings = watched.node.settings
        with watched.node.live.editing() as scene:
            scene.maps.told_apart = lambda _, told=settings.told_apart: told
            (named,) = scene.maps.finer_rules() or ['']
            assert scene.maps.finer_rules('hands off') == ([named] if named else [])
            assert scene.maps.finer_rules('another') == []
            assert (named in scene.troubles()) == bool(named)
        assert named.startswith('proximity rules hands off are' if limit else '')
        assert limit in named
