"""The node as if every distance were 1 cm too large; started by test_cross_check.py."""

import sys

from drake_geom_ros.geometry import SignedDistanceResults
from drake_geom_ros.ros.scene_graph_node import main

_right = SignedDistanceResults.distance.fget
SignedDistanceResults.distance = property(lambda results: _right(results) + 0.01)

if __name__ == '__main__':
    sys.exit(main())
