"""Command-line options for the topic names of a recording."""

import argparse

from drake_geom_ros.recordings import Topics
from drake_geom_ros.recordings.recording_topics import NAMES


def add_topics_to(parser: argparse.ArgumentParser) -> None:
    """Add options for namespace, remapped topics and world frame."""
    parser.add_argument(
        '--topic',
        action='append',
        default=[],
        metavar='NAME=TOPIC',
        help='another topic of a recording than the usual one, or none: NAME is one of '
        f'{", ".join(NAMES)}; obstacles, of which a node made maps, may be several with commas '
        'between, and are all clouds, OctoMaps and depth images where none are named',
    )
    parser.add_argument(
        '--namespace',
        default='',
        metavar='NAME',
        help='where a recording has joint_states, robot_description and so on',
    )
    parser.add_argument(
        '--world-frame',
        default='world',
        metavar='NAME',
        help='as TF calls it in a recording (default: world)',
    )


def topics_of(options: argparse.Namespace) -> Topics:
    """Return the topics of the options; raises RecordingError for an unknown name."""
    return Topics.of(options.topic, options.namespace)
