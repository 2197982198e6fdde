"""What ROS recorded, judged without ROS: how near things came, when, and what is not known.

``clearance`` is all that most callers need::

    found = clearance('run.mcap', 'cell.yaml', between=['left:right'])
    assert found.least().distance > 0.05

In: recordings (MCAP, sqlite3), and a scene file or the robot's description in them.
Out: least distances over time, what was left out, stale or damaged; tables, plots, a report.
May import: ``math``, ``common``, ``sensors``, ``geometry``, ``proximity_rules``, ``sensed_maps``,
    ``scene_files``, ``ros``, of which only rooms without ROS, ``batch``, ``replay``, ``viewing``;
    numpy, yaml, rosbags, mcap, lz4, zstandard, matplotlib, PIL.
"""

from drake_geom_ros.recordings.audit import Audit, Audited, audit
from drake_geom_ros.recordings.clearance import clearance
from drake_geom_ros.recordings.comparing import PairDifference, SetComparison, compare_runs
from drake_geom_ros.recordings.errors import IncompleteRecordingError, RecordingError
from drake_geom_ros.recordings.recorded_pairs import Outcome
from drake_geom_ros.recordings.results import Clearances
from drake_geom_ros.recordings.set_clearance import Moment, SetClearance, Span
from drake_geom_ros.recordings.topics import Topics

__all__ = [
    'audit',
    'Audit',
    'Audited',
    'clearance',
    'Clearances',
    'compare_runs',
    'IncompleteRecordingError',
    'Moment',
    'Outcome',
    'PairDifference',
    'RecordingError',
    'SetClearance',
    'SetComparison',
    'Span',
    'Topics',
]
