"""What is raised about recordings."""

from drake_geom_ros.geometry import GeometryError


class RecordingError(GeometryError):
    """A recording that cannot be read, or has not what it is asked for."""


class IncompleteRecordingError(RecordingError):
    """A figure is asked of a recording that does not tell all that it would take."""
