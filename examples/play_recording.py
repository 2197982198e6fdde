"""Publish the messages of a recording again, as `ros2 bag play` does (extra `recordings`).

    python examples/play_recording.py RUN [--rate 1.0] [--topic /joint_states ...]

RUN is a folder that `ros2 bag record` or `./run record` wrote. Messages keep the times between
them; what was published latched is latched again.
"""

import argparse
import time
from importlib import import_module
from pathlib import Path

import rclpy
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.highlevel import AnyReader


def publisher_for(node, connection):
    """Return a publisher of the type and the durability of a recorded topic."""
    package, _, name = connection.msgtype.split('/')
    offered = connection.ext.offered_qos_profiles
    latched = any(profile.durability.name == 'TRANSIENT_LOCAL' for profile in offered)
    durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
    kind = getattr(import_module(f'{package}.msg'), name)
    return node.create_publisher(
        kind, connection.topic, QoSProfile(depth=10, durability=durability)
    )


def play(node, reader, options):
    """Publish all messages of a reader in their order; return their number."""
    recorded = sorted({each.topic for each in reader.connections})
    if missing := sorted(set(options.topic) - set(recorded)):
        raise SystemExit(f'{missing[0]} is not in {options.run}; topics: {", ".join(recorded)}')
    chosen = [each for each in reader.connections if each.topic in (options.topic or recorded)]
    publishers = {each.topic: publisher_for(node, each) for each in chosen}
    time.sleep(options.wait)
    begin, count = time.monotonic(), 0
    for connection, stamp, data in reader.messages(chosen):
        due = begin + (stamp - reader.start_time) * 1e-9 / options.rate
        time.sleep(max(0.0, due - time.monotonic()))
        publishers[connection.topic].publish(bytes(data))
        count += 1
    for publisher in publishers.values():  # what is under way is lost with its publisher
        publisher.wait_for_all_acked(Duration(seconds=5))
    return count


def main():
    """Play a recording to its end."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('run', type=Path, metavar='RUN')
    parser.add_argument('--rate', type=float, default=1.0, help='2: twice as fast')
    parser.add_argument('--wait', type=float, default=2.0, help='for subscribers, at first [s]')
    parser.add_argument('--topic', action='append', default=[], help='these alone')
    options = parser.parse_args()
    if not options.rate > 0.0:
        parser.error(f'--rate is {options.rate:g}; it must be positive')
    rclpy.init()
    node = rclpy.create_node('play_recording')
    with AnyReader([options.run]) as reader:
        print(f'{play(node, reader, options)} messages of {options.run}')
    node.destroy_node()
    rclpy.shutdown()


if __name__ == '__main__':
    main()
