"""The node, but what it loads is warmed up no sooner than a cleanup has begun."""

import sys
import threading

from drake_geom_ros.live.scene.changes import addition
from drake_geom_ros.ros import scene_graph_node

warm_up, on_cleanup = addition.warm_up, scene_graph_node.SceneGraphNode.on_cleanup
begun = threading.Event()


def slowly(*what):
    print('warming up', flush=True)
    begun.wait()
    return warm_up(*what)


def cleaning_up(*what):
    begun.set()
    return on_cleanup(*what)


addition.warm_up = slowly
scene_graph_node.SceneGraphNode.on_cleanup = cleaning_up

if __name__ == '__main__':
    sys.exit(scene_graph_node.main())
