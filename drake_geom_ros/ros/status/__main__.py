"""``python -m drake_geom_ros.ros.status``: what a running node has and does."""

import sys

from drake_geom_ros.ros.status.program import main

if __name__ == '__main__':
    sys.argv[0] = 'status'  # as its help shows
    sys.exit(main())
