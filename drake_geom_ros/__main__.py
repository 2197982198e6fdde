"""``python -m drake_geom_ros``: answers about a scene file, without ROS."""

import sys

from drake_geom_ros.programs import drake_geom_ros

if __name__ == '__main__':
    sys.exit(drake_geom_ros(prog='python -m drake_geom_ros'))
