"""Many states of one scene at once: on all cores, and by executors, those of clusters too.

``evaluate`` is all that most callers need::

    loaded = load_scene('scenes/two_pandas.yaml', scene_graph)
    joints = Joints.of(loaded)
    rng = numpy.random.default_rng(0)
    states = rng.uniform(joints.lower, joints.upper, (10_000, joints.count))
    clearance = evaluate(scene_graph, want='least', states=states, joints=joints).distance

Every answer is, to the bit, that of a query about its state alone, whatever the number of threads
or workers, the size of the blocks and the order of the states.

In: a scene, states (N, ...), what is wanted of each.
Out: arrays by state, or a file of them.
May import: ``math``, ``common``, ``geometry``, ``scene_files``, ``trajectories``; numpy,
    distributed, matplotlib, pyarrow.
"""

from drake_geom_ros.batch.checker import Checker, Clearance
from drake_geom_ros.batch.cluster import cluster_executor
from drake_geom_ros.batch.contacts import ContactsOfStates
from drake_geom_ros.batch.evaluation import evaluate
from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.batch.paths import PathChecker, check_path, check_paths
from drake_geom_ros.batch.questions import WANTS, Question
from drake_geom_ros.batch.results import LeastDistances, PairsOfStates, PointsOfStates
from drake_geom_ros.batch.running import BatchError

__all__ = [
    'Checker',
    'Clearance',
    'PathChecker',
    'evaluate',
    'check_path',
    'check_paths',
    'Joints',
    'ContactsOfStates',
    'LeastDistances',
    'PairsOfStates',
    'PointsOfStates',
    'Question',
    'WANTS',
    'cluster_executor',
    'BatchError',
]
