"""The node, but has_collisions waits in C for ever, and get_filters does so with Python's lock."""

import ctypes
import sys

from drake_geom_ros.ros import scene_graph_node
from drake_geom_ros.ros.services import table

STUCK = {
    'has_collisions': lambda *anything: ctypes.CDLL(None).pause(),
    'get_filters': lambda *anything: ctypes.PyDLL(None).pause(),
}
table.BESIDE = tuple((name, kind, STUCK.get(name, serve)) for name, kind, serve in table.BESIDE)
scene_graph_node.ConfiguredNode._open_services.__globals__['BESIDE'] = table.BESIDE

if __name__ == '__main__':
    sys.exit(scene_graph_node.main())
