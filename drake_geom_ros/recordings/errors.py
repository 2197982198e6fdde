"""Errors about recordings."""

from drake_geom_ros.geometry import GeometryError


class RecordingError(GeometryError):
    """A recording cannot be read, or lacks what is requested."""


class IncompleteRecordingError(RecordingError):
    """A recording is incomplete, and the caller did not allow that."""
