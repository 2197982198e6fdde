"""The node, but it takes 2 s to rehearse what is loaded."""

import sys
import time

from drake_geom_ros.ros import scene_graph_node
from drake_geom_ros.ros.services import files

files.rehearse = lambda *anything: time.sleep(2.0)

if __name__ == '__main__':
    sys.exit(scene_graph_node.main())
