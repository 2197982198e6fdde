"""The node, but a change of the scene is prepared for as long as a filter has a lease."""

import sys
import time

from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.ros import scene_graph_node

make_change = LiveScene.change


def has_leases(live):
    with live.reading() as scene:
        return bool(scene.filters.leases())


def change(live, *what, **how):
    print('preparing', flush=True)
    while has_leases(live):
        time.sleep(0.01)
    return make_change(live, *what, **how)


LiveScene.change = change

if __name__ == '__main__':
    sys.exit(scene_graph_node.main())
