"""Which nearness means warn, slow down or stop, decided by certified lower bounds.

In: rules, names and filters of a scene, what a cycle measured.
Out: events, the state of each rule, the scale of speed.
May import: ``math``, ``common``, ``geometry``; numpy.
"""

from drake_geom_ros.proximity_rules.decisions import Poses
from drake_geom_ros.proximity_rules.events import Event
from drake_geom_ros.proximity_rules.measured import Measured
from drake_geom_ros.proximity_rules.monitor import RuleMonitor, RuleState, RuleStates
from drake_geom_ros.proximity_rules.rule import (
    Level,
    ProximityRule,
    RuleError,
    Why,
    scale_points,
)
from drake_geom_ros.proximity_rules.watched_pairs import ScenePairs, WatchedPairs

__all__ = [
    'Event',
    'Level',
    'Measured',
    'Poses',
    'ProximityRule',
    'RuleError',
    'RuleMonitor',
    'RuleState',
    'RuleStates',
    'ScenePairs',
    'WatchedPairs',
    'Why',
    'scale_points',
]
