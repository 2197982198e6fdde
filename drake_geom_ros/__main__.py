"""``python -m drake_geom_ros``: answers about a scene file, without ROS."""

import sys

from drake_geom_ros.command_line.program import main

if __name__ == '__main__':
    sys.exit(main(prog='python -m drake_geom_ros'))
