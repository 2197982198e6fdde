"""Queries about many states of one scene at once, on all cores, by executors or on clusters.

``evaluate`` is all that most callers need::

    loaded = load_scene('scenes/two_pandas.yaml', scene_graph)
    joints = Joints.of(loaded)
    rng = numpy.random.default_rng(0)
    states = rng.uniform(joints.lower, joints.upper, (10_000, joints.count))
    clearance = evaluate(scene_graph, want='least', states=states, joints=joints).distance

Every answer equals, to the bit, that of a query about its state alone. The number of threads or
workers, the size of the blocks and the order of the states do not matter. Results are arrays by
state, or files of them.
"""

from drake_geom_ros.batch.checker import Checker, Clearance
from drake_geom_ros.batch.cluster import cluster_executor
from drake_geom_ros.batch.contacts import ContactsOfStates
from drake_geom_ros.batch.distance_field import DistanceField, sample_sdf
from drake_geom_ros.batch.distance_gradients import (
    ClearanceAndGradient,
    DistancesAndGradients,
    NearPairs,
)
from drake_geom_ros.batch.evaluation import evaluate
from drake_geom_ros.batch.joint_trajectories import (
    ClearanceBounds,
    FastestGeometry,
    cartesian_speed,
    check_trajectory,
    clearance_bounds,
)
from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.batch.paths import PathChecker, check_path, check_paths
from drake_geom_ros.batch.questions import WANTS, Question
from drake_geom_ros.batch.results import LeastDistances, PairsOfStates, PointsOfStates
from drake_geom_ros.batch.running import BatchError

__all__ = [
    'Checker',
    'Clearance',
    'ClearanceAndGradient',
    'DistancesAndGradients',
    'NearPairs',
    'PathChecker',
    'evaluate',
    'check_path',
    'check_paths',
    'check_trajectory',
    'clearance_bounds',
    'ClearanceBounds',
    'cartesian_speed',
    'FastestGeometry',
    'Joints',
    'ContactsOfStates',
    'LeastDistances',
    'PairsOfStates',
    'PointsOfStates',
    'Question',
    'WANTS',
    'DistanceField',
    'sample_sdf',
    'cluster_executor',
    'BatchError',
]
