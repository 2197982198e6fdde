"""Errors of scene files, which name the file, the line and the key."""

from dataclasses import dataclass

from drake_geom_ros.geometry.errors import GeometryError


class SceneFileError(GeometryError):
    """A scene, URDF or SRDF file that cannot be loaded, or a scene that cannot be saved.

    ``str(error)`` reads ``arms.yaml:12: geometries[3].shape.radius: -1.0 must be > 0``; the same
    parts are the attributes ``file``, ``line`` (None if no line is at fault), ``key`` and
    ``reason``.
    """

    def __init__(self, reason: str, file: str, line: int | None = None, key: str = ''):
        where = file if line is None else f'{file}:{line}'
        super().__init__(': '.join(part for part in (where, key, reason) if part))
        self.reason = reason
        self.file = file
        self.line = line
        self.key = key


def unreadable(file: str, error: OSError) -> SceneFileError:
    """Return the error for a file that the system does not let us read."""
    return SceneFileError(f'cannot be read: {error.strerror}', file)


@dataclass(frozen=True)
class Location:
    """A place in a file, for errors about it."""

    file: str
    line: int | None = None
    key: str = ''

    def __str__(self) -> str:
        """Return the place as errors show it: file, line and key, as far as they are known."""
        line = '' if self.line is None else f':{self.line}'
        return f'{self.file}{line}{f": {self.key}" if self.key else ""}'

    def error(self, reason: str) -> SceneFileError:
        """Return an error about this place, with the ``reason``."""
        return SceneFileError(reason, self.file, self.line, self.key)
