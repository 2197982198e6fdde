"""Zones in a running node: events, saved scenes, replays of events, registration by services."""

import pytest
from drake_geom_msgs import msg, srv
from rcl_interfaces.msg import ParameterValue
from ros.harness import LATCHED
from ros.scene_calls import accepted, poses

from drake_geom_ros.replay import Finding, Judge, events_of

pytestmark = pytest.mark.topics

SCENE = """
name: zoned
sources: [cart]
frames: [{name: chassis, source: cart, static: false}]
geometries:
- {name: chassis, source: cart, frame: chassis, shape: {type: box, size: [0.4, 0.4, 0.4]}}
- {name: zone, source: cart, frame: chassis, sensor: true,
   shape: {type: polygon, points: [[0.3, -1], [1, -1], [1, 1], [0.6, 0], [0.3, 1]], height: 1}}
- {name: post, shape: {type: sphere, radius: 0.1}}
proximity_rules:
- {name: in zone, set_a: zone, set_b: post, level: stop, enter: 0.0, leave: 0.02, min_points: 3}
"""
IN, OUT = (-0.5, 0.0, -0.5), (-2.0, 0.0, -0.5)


class Cart:
    def __init__(self, client):
        self.client = client
        self._poses = client.publisher(msg.FramePoses, 'frame_poses')
        self.states = client.listen(msg.ProximityStates, 'proximity_states', LATCHED)

    def entered(self, rule):
        """Return whether a rule is entered, as its last state says."""
        if not self.states or rule not in self.states[-1].rules.name:
            return None
        return self.states[-1].entered[list(self.states[-1].rules.name).index(rule)]

    def until(self, place, rule, entered):
        """Stand at a place until a rule is entered or left."""

        def holds():
            message = poses(['chassis'], [place], source='cart')
            message.header.stamp = self.client.node.get_clock().now().to_msg()
            self._poses.publish(message)
            return self.entered(rule) is entered

        self.client.wait_for(holds, f'{rule} to be {"entered" if entered else "left"}')


def test_a_zone_of_a_node(client):
    accepted(client.call(srv.LoadScene, 'load_scene', text=SCENE, format='yaml', replace=True))
    cart, events = Cart(client), client.listen(msg.ProximityEvents, 'proximity_events', 1000)
    cart.until(OUT, 'in zone', False)
    cart.until(IN, 'in zone', True)
    client.wait_for(lambda: [m for m in events if 'in zone' in m.rule and m.why[0] == 1], 'event')
    saved = accepted(client.call(srv.SaveScene, 'save_scene')).text
    assert 'sensor: true' in saved
    assert 'min_points: 3' in saved
    event = next(m for m in events if m.why[0] == msg.ProximityEvents.NEAR and m.entered[0])
    assert 'cart::chassis/zone' in (event.geometry_a[0], event.geometry_b[0])
    fields = {name: getattr(event, name) for name in event.get_fields_and_field_types()}
    verdict = Judge(saved).verdict(next(iter(events_of(fields))))
    assert verdict.finding == Finding.FOUNDED
    assert verdict.distance < 0.0
    answer = accepted(
        client.call(srv.ComputeSignedDistancePairwise, 'compute_signed_distance_pairwise')
    )
    assert len(answer.result.distance) == 1  # of the chassis and the post
    accepted(client.call(srv.LoadScene, 'load_scene', text=saved, format='yaml', replace=True))
    cart.until(OUT, 'in zone', False)
    cart.until(IN, 'in zone', True)


def test_a_zone_by_services(client):
    accepted(client.call(srv.LoadScene, 'load_scene', text=SCENE, format='yaml', replace=True))
    role = msg.Role(role=msg.Role.ILLUSTRATION)
    value = ParameterValue(type=1, bool_value=True)
    role.properties = [msg.Property(group='proximity_rules', name='sensor', value=value)]
    ball = msg.Shape(type=msg.Shape.SPHERE, dimensions=[0.5])
    fields = {'source': 'cart', 'frame': 'chassis', 'name': 'ball', 'shape': ball, 'roles': [role]}
    accepted(client.call(srv.RegisterGeometry, 'register_geometry', **fields))
    rule = msg.ProximityRule(name='ball', set_a=['ball'], set_b=['post'], level=3, leave=0.1)
    answer = accepted(client.call(srv.AddProximityRule, 'add_proximity_rule', rule=rule))
    assert answer.pairs == 1
    cart = Cart(client)
    cart.until((2.0, 0.0, 0.0), 'ball', False)
    cart.until((0.4, 0.0, 0.0), 'ball', True)
    assert not cart.entered('in zone')
