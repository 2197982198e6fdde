"""Replay files: an answer that violated its guarantee, with all that reproduces it.

``recorded`` makes a Replay of a result, ``write`` and ``read`` keep it in a file, and
``reproduce`` rebuilds the scene and queries the pair again. ``read_events`` reads recorded
proximity events, and a ``Judge`` computes their decisions again.
"""

from drake_geom_ros.replay.file import read, write
from drake_geom_ros.replay.recomputed_decisions import Finding, Judge, Verdict
from drake_geom_ros.replay.record import Answer, Opinion, Question, Replay, recorded
from drake_geom_ros.replay.recorded_events import RecordedEvent, events_of, read_events
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
