"""``python -m drake_geom_ros.ros.demo``: a node, a player and a client, shown."""

import sys

from drake_geom_ros.ros.demo.program import main

if __name__ == '__main__':
    sys.exit(main())
