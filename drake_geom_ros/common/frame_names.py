"""Frames by ``source::frame``, where either name may hold ``::``: looked up whole, never split."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

Frame = tuple[str, str]  # a source, and the frame's own name


class AmbiguousNameError(ValueError):
    """A text that several frames bear."""


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
        """Return the frame of a full name, None where there is none.

        Raises AmbiguousNameError, which names them, where there are several.
        """
        found = self._frames.get(text, [])
        if len(found) > 1:
            both = ' and '.join(told_apart(frame) for frame in found)
            raise AmbiguousNameError(f'{text!r} stands for {both}; rename one of them')
        return found[0] if found else None

    def label(self, frame: Frame) -> str:
        """Return a text for people that no other frame has: the full name if that does."""
        name = full_name(frame)
        return name if len(self._frames[name]) == 1 else told_apart(frame)


def told_apart(frame: Frame) -> str:
    """Return a frame in words that leave no doubt where its source ends."""
    source, name = frame
    return f'{name!r} of source {source!r}'
