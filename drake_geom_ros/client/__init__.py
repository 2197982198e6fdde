"""Client of a scene_graph node: queries by service and results with names, for nodes and scripts.

``SceneGraphClient`` is for scripts: it has its own node, and its calls wait for the answer.
``SceneListener``, ``Services`` and ``HeldFilter`` are for nodes that spin themselves. Errors name
the node or service that does not answer.
"""

from drake_geom_ros.client.blocking import NoAnswerError, SceneGraphClient
from drake_geom_ros.client.contact_surfaces import (
    ContactSurface,
    ContactSurfaces,
    PairsWithoutSurface,
    PairWithoutSurface,
)
from drake_geom_ros.client.held_filter import HeldFilter, sleep
from drake_geom_ros.client.left_out import IncompleteError, StaleError
from drake_geom_ros.client.listening import SceneListener
from drake_geom_ros.client.motions import Motion
from drake_geom_ros.client.proximity_monitor import (
    ProximityEvent,
    ProximityMonitor,
    RuleStanding,
)
from drake_geom_ros.client.requests import RequestError
from drake_geom_ros.client.results import (
    Penetration,
    Penetrations,
    PointDistance,
    PointDistances,
    SignedDistance,
    SignedDistances,
)
from drake_geom_ros.client.scene_table import (
    Geometry,
    Joint,
    JointState,
    SceneTable,
    UnknownNameError,
)
from drake_geom_ros.client.services import (
    RefusedError,
    Services,
    exclude_between,
    frame_poses,
    joint_positions,
)
from drake_geom_ros.client.states import States
from drake_geom_ros.client.trajectories import TrajectoryState, TrajectoryStates

__all__ = [
    'SceneGraphClient',
    'SceneListener',
    'Services',
    'HeldFilter',
    'SceneTable',
    'Geometry',
    'Joint',
    'JointState',
    'SignedDistances',
    'SignedDistance',
    'Penetrations',
    'Penetration',
    'PointDistances',
    'PointDistance',
    'ContactSurfaces',
    'ContactSurface',
    'PairsWithoutSurface',
    'PairWithoutSurface',
    'RefusedError',
    'RequestError',
    'NoAnswerError',
    'IncompleteError',
    'StaleError',
    'UnknownNameError',
    'States',
    'Motion',
    'TrajectoryState',
    'TrajectoryStates',
    'ProximityMonitor',
    'ProximityEvent',
    'RuleStanding',
    'frame_poses',
    'joint_positions',
    'exclude_between',
    'sleep',
]
