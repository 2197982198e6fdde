"""Lookup of frames by ``source::frame`` as a whole, since both names may contain ``::``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

Frame = tuple[str, str]  # a source, and the frame's own name


class AmbiguousNameError(ValueError):
    """A full name that several frames share."""


def full_name(frame: Frame) -> str:
    """Return ``source::frame``."""
    source, name = frame
    return f'{source}::{name}'


class FrameNames:
    """The frames of a scene by their full names."""

    def __init__(self, frames: Iterable[Frame]) -> None:
        self._frames: dict[str, list[Frame]] = {}
        for frame in dict.fromkeys(frames):
            self._frames.setdefault(full_name(frame), []).append(frame)

    def __iter__(self) -> Iterator[str]:
        return iter(self._frames)

    def find(self, text: str) -> Frame | None:
        """Return the frame of a full name, or None if there is none.

        Raises AmbiguousNameError, which names them, if there are several.
        """
        frames = self._frames.get(text, [])
        if len(frames) > 1:
            both = ' and '.join(unambiguous_name(frame) for frame in frames)
            raise AmbiguousNameError(f'{text!r} stands for {both}; rename one of them')
        return frames[0] if frames else None

    def label(self, frame: Frame) -> str:
        """Return a unique text for a frame: its full name if that is unique."""
        name = full_name(frame)
        return name if len(self._frames[name]) == 1 else unambiguous_name(frame)


def unambiguous_name(frame: Frame) -> str:
    """Return a text for a frame that separates its name from its source."""
    source, name = frame
    return f'{name!r} of source {source!r}'
