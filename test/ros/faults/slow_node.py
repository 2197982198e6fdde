"""The node, but it takes 2 s to warm_up what is loaded."""

import sys
import time

from drake_geom_ros.ros import scene_graph_node
from drake_geom_ros.ros.scene import live_scene

warm_up = live_scene.warm_up


def slowly(*what):
    time.sleep(2.0)
    return warm_up(*what)


live_scene.warm_up = slowly

if __name__ == '__main__':
    sys.exit(scene_graph_node.main())
