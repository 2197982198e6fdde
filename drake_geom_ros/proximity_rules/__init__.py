"""Proximity rules: warn, slow down or stop when pairs of geometries come near.

A rule decides by certified lower bounds of the distances that a cycle measured. Rules give events,
the state of each rule, and a scale of speed for the robot.
"""

from drake_geom_ros.proximity_rules.decisions import Poses
from drake_geom_ros.proximity_rules.events import Event
from drake_geom_ros.proximity_rules.measured import Measured, UnseenBodies
from drake_geom_ros.proximity_rules.monitor import (
    RuleMonitor,
    RuleState,
    RuleStates,
    ScaleOfRobot,
)
from drake_geom_ros.proximity_rules.named_geometries import NamedGeometries, geometry_names
from drake_geom_ros.proximity_rules.rule import (
    Level,
    ProximityRule,
    RuleError,
    Why,
    scale_points,
    stopping_points,
)
from drake_geom_ros.proximity_rules.unseen_bodies import unseen_of_groups, unseen_of_rule
from drake_geom_ros.proximity_rules.watched_pairs import ScenePairs, WatchedKinds, WatchedPairs
from drake_geom_ros.proximity_rules.zones import (
    SENSOR,
    SOLID,
    Zones,
    check_zone,
    is_zone,
    named_zones,
    properties_of_zone,
    zones_in,
)

__all__ = [
    'Event',
    'Level',
    'Measured',
    'NamedGeometries',
    'SENSOR',
    'SOLID',
    'Poses',
    'ProximityRule',
    'RuleError',
    'RuleMonitor',
    'RuleState',
    'RuleStates',
    'ScaleOfRobot',
    'ScenePairs',
    'UnseenBodies',
    'WatchedKinds',
    'WatchedPairs',
    'Why',
    'Zones',
    'check_zone',
    'geometry_names',
    'is_zone',
    'named_zones',
    'properties_of_zone',
    'scale_points',
    'stopping_points',
    'unseen_of_groups',
    'unseen_of_rule',
    'zones_in',
]
