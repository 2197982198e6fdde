"""The node, but it takes 2 s to warm_up what is loaded."""

import sys
import time

from drake_geom_ros.ros import scene_graph_node
from drake_geom_ros.ros.services import files

files.warm_up = lambda *anything: time.sleep(2.0)

if __name__ == '__main__':
    sys.exit(scene_graph_node.main())
