"""The node, but it prints what is called so often under the scene's lock as by a loop over all.

The number of calls in our code, of our functions and Python's, does not depend on how fast the
machine is.
"""

import os
import sys
import threading
from collections import Counter
from pathlib import Path

import drake_geom_ros
from drake_geom_ros.live.scene import live_scene
from drake_geom_ros.ros import scene_graph_node

PACKAGE = str(Path(drake_geom_ros.__file__).parent)
MANY = int(os.environ['MOST_CALLS_UNDER_THE_LOCK'])


class CountingLock:
    """A lock that counts the calls of whoever has it, by function."""

    def __init__(self):
        self._lock, self._depth, self._calls = threading.RLock(), 0, Counter()
        self._caller = ''

    def __enter__(self):
        self._lock.acquire()
        self._depth += 1
        if self._depth == 1:
            self._calls.clear()
            # Behind the method of the scene and its context manager.
            self._caller = sys._getframe(3).f_code.co_name
            sys.setprofile(self._count)

    def __exit__(self, *exception):
        if self._depth == 1:
            sys.setprofile(None)
            often = [(name, n) for name, n in self._calls.most_common(5) if n >= MANY]
            if often:
                print(f'under the lock, by {self._caller}: {often}', flush=True)
        self._depth -= 1
        self._lock.release()

    def _count(self, frame, event, called):
        if not frame.f_code.co_filename.startswith(PACKAGE):
            return  # kernels that are loaded once, and what libraries do inside
        if event == 'call':
            self._calls[frame.f_code.co_name] += 1
        elif event == 'c_call':
            self._calls[called.__qualname__] += 1


class CountedScene(live_scene.LiveScene):
    """A live scene with such a lock."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self._lock = CountingLock()


if __name__ == '__main__':
    scene_graph_node.LiveScene = CountedScene
    sys.exit(scene_graph_node.main())
