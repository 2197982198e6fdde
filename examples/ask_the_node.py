"""Move a frame of a running node's scene and print its answers: topics and services only.

Start the node with scenes/minimal.yaml first, see the README.
"""

import rclpy
from drake_geom_msgs.msg import FramePoses, Scene, SignedDistancePairs
from drake_geom_msgs.srv import ExplainFilter
from rclpy.qos import DurabilityPolicy, QoSProfile


def main():
    """Lower the ball on the floor in three steps."""
    rclpy.init()
    node = rclpy.create_node('ask_the_node')
    names, answers = {}, []

    def keep_names(scene):
        frames = {frame.id: frame.name for frame in scene.frames}
        names.update({g.id: f'{frames[g.frame_id]}/{g.name}' for g in scene.geometries})

    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(Scene, '/scene_graph/scene', keep_names, latched)
    node.create_subscription(
        SignedDistancePairs, '/scene_graph/signed_distances', answers.append, 10
    )
    poses = node.create_publisher(FramePoses, '/scene_graph/frame_poses', 10)
    explain = node.create_client(ExplainFilter, '/scene_graph/explain_filter')
    explain.wait_for_service()
    while not (names and poses.get_subscription_count() and node.count_publishers(answers_topic)):
        rclpy.spin_once(node, timeout_sec=0.1)

    for height in (0.3, 0.1, 0.05):
        message = FramePoses(frame_names=['ball'], poses=[0.2, 0.0, height, 0.0, 0.0, 0.0, 1.0])
        message.header.stamp.nanosec = int(1000 * height)  # tells this answer from others
        while not any(a.header.stamp == message.header.stamp for a in answers):
            poses.publish(message)
            rclpy.spin_once(node, timeout_sec=0.1)
        answer = next(a for a in answers if a.header.stamp == message.header.stamp)
        for k, pair in enumerate(zip(answer.id_a, answer.id_b, strict=True)):
            a, b = (names[id] for id in pair)
            print(f'ball at {height} m: {a} to {b}: {answer.distance[k]:.6f} m')

    future = explain.call_async(
        ExplainFilter.Request(geometry_a='world/floor', geometry_b='world/post')
    )
    rclpy.spin_until_future_complete(node, future)
    print('floor to post is left out:', ', '.join(future.result().reasons))
    node.destroy_node()
    rclpy.shutdown()


answers_topic = '/scene_graph/signed_distances'

if __name__ == '__main__':
    main()
