"""Analysis of ROS recordings, without ROS: minimum distances over time, with gaps stated.

``clearance`` is all that most callers need::

    over_time = clearance('run.mcap', 'cell.yaml', between=['left:right'])
    assert over_time.least().distance > 0.05

A recording (MCAP or sqlite3) needs a scene file, or the robot's description in the recording. The
result names the times that are unknown because poses were missing, stale or damaged. It makes
tables, plots and a report.
"""

from drake_geom_ros.recordings.audit import Audit, Audited, audit
from drake_geom_ros.recordings.clearance import clearance
from drake_geom_ros.recordings.comparing import PairDifference, SetComparison, compare_runs
from drake_geom_ros.recordings.errors import IncompleteRecordingError, RecordingError
from drake_geom_ros.recordings.recorded_pairs import Outcome
from drake_geom_ros.recordings.recording_topics import Topics
from drake_geom_ros.recordings.results import Clearances
from drake_geom_ros.recordings.set_clearance import Moment, SetClearance, Span

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
