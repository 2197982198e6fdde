"""Replay files without ROS: an answer that broke a promise, and all it takes to ask again.

``recorded`` makes a Replay of a result, ``write`` and ``read`` keep it in a file, and
``reproduce`` rebuilds the scene and asks for the pair once more. ``read_events`` reads recorded
proximity events, and a ``Judge`` computes their decisions again.

In: an answer that broke a promise, or a file.
Out: all that it takes to ask again, as a file or rebuilt; whether a decision was founded.
May import: ``math``, ``common``, ``geometry``, ``proximity_rules``, ``scene_files``; numpy, yaml.
"""

from drake_geom_ros.replay.decisions import Finding, Judge, Verdict
from drake_geom_ros.replay.events import RecordedEvent, events_of, read_events
from drake_geom_ros.replay.file import read, write
from drake_geom_ros.replay.record import Answer, Opinion, Question, Replay, recorded
from drake_geom_ros.replay.reproduction import reproduce

__all__ = [
    'Answer',
    'Finding',
    'Judge',
    'Opinion',
    'Question',
    'RecordedEvent',
    'Replay',
    'Verdict',
    'read',
    'events_of',
    'read_events',
    'recorded',
    'reproduce',
    'write',
]
