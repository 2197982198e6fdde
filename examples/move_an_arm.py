"""Move an arm of a running node by its joint states, as its driver does, and print what is near.

Start the node with scenes/two_pandas.yaml and use_joint_states first, see the README.
"""

from rclpy.time import Time
from sensor_msgs.msg import JointState

from drake_geom_ros.client import SceneGraphClient

ARM = [f'left::panda_joint{k}' for k in range(1, 8)]
FINGER = 'left::panda_finger_joint1'


def main():
    """Lower the left arm in three steps; then ask about a step that it does not take."""
    with SceneGraphClient() as client:
        results = []
        client.listener.on_signed_distances(results.append)
        publisher = client.node.create_publisher(JointState, '/joint_states', 10)

        def results_at(angle):
            """Send where the joints are, and return the result for that once it has come."""
            message = JointState(name=[*ARM, FINGER])
            message.position = [0.0, angle, 0.0, -2.356, 0.0, 1.571, 0.785, 0.04]  # [rad], [m]
            message.header.stamp = Time(seconds=1 + angle).to_msg()  # tells results apart
            publisher.publish(message)
            return [found for found in results if abs(found.stamp - 1 - angle) < 1e-6]

        for angle in (-0.5, 0.0, 0.3):
            (found, *_) = client.wait_for(lambda a=angle: results_at(a), 'a result')
            print(f'second joint at {angle} rad:', said_of(found))

        found = client.signed_distances(joints={'left::panda_joint2': 0.5}, max_distance=0.3)
        print('if it were at 0.5 rad:', said_of(found))


def said_of(found):
    """Return what of the room is nearest to the left arm, from a result."""
    pair = found.between('left', 'scenery').closest()
    return f'{pair.name_a} to {pair.name_b}, {pair.distance:.4f} m +- {pair.error_bound:.0e}'


if __name__ == '__main__':
    main()
