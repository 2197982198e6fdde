"""The groups of callbacks that have a thread each; the others share the main one."""

from __future__ import annotations

import time
from typing import NamedTuple

from rclpy.callback_groups import CallbackGroup

# Cleanup is answered in time for clients that wait 10 s, and a load may compile for longer.
LONGEST_FAREWELL = 5.0  # [s]
_LOOKS = 0.01  # [s] between two looks whether services are at work


class CallbackGroups(NamedTuple):
    """One group for each kind of work that must not wait for another."""

    stream: CallbackGroup  # poses and cycles
    beside: CallbackGroup  # queries, and what is drawn
    changes: CallbackGroup  # of frames, filters and rules
    loading: CallbackGroup  # what may read files and compile
    images: CallbackGroup  # what cameras see
    planning: CallbackGroup  # many states at once
    motions: CallbackGroup  # whole motions
    watching: CallbackGroup  # trajectories that run
    obstacles: CallbackGroup  # what sensors see
    tracked: CallbackGroup  # bodies that trackers see

    def let_answers_go(self) -> bool:
        """Wait until no service is at work in another thread: closed before, it cannot answer.

        Return whether none is, for it does not wait for ever.
        """
        end = time.monotonic() + LONGEST_FAREWELL
        queries = self.beside, self.images, self.planning, self.motions, self.watching
        threads = *queries, self.changes, self.loading
        while any(map(_at_work, threads)):
            if time.monotonic() > end:
                return False
            time.sleep(_LOOKS)
        return True


def _at_work(group: CallbackGroup) -> bool:
    """Return whether a callback of a group runs, the sending of its answer included."""
    entities = [entity for each in list(group.entities) if (entity := each()) is not None]
    return bool(entities) and not group.can_execute(entities[0])
