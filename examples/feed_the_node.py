"""Feed a running node: a robot by its description, poses of its links, and points to measure.

Start the node with scenes/minimal.yaml and point_threshold 1.0 first, see docs/inputs.md.
"""

import array

from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import String

from drake_geom_ros.client import SceneGraphClient

PROBE = """
<robot name="probe">
  <link name="shaft">
    <collision name="rod"><geometry><cylinder radius="0.02" length="0.4"/></geometry></collision>
  </link>
  <link name="tip">
    <collision name="ball"><geometry><sphere radius="0.05"/></geometry></collision>
  </link>
  <joint name="joint" type="fixed"><parent link="shaft"/><child link="tip"/></joint>
</robot>
"""
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def cloud_of(points, frame_id, stamp_sec):
    """Return a PointCloud2 of points (x, y, z) in a frame."""
    numbers = array.array('f', [value for point in points for value in point])
    fields = [
        PointField(name=axis, offset=4 * k, datatype=PointField.FLOAT32, count=1)
        for k, axis in enumerate('xyz')
    ]
    cloud = PointCloud2(height=1, width=len(points), fields=fields, point_step=12)
    cloud.row_step = 12 * len(points)
    cloud.data = array.array('B', numbers.tobytes())
    cloud.header.frame_id, cloud.header.stamp.sec = frame_id, stamp_sec
    return cloud


def main():
    """Add a robot, move it, and measure two points from its tip."""
    with SceneGraphClient() as client:
        answers = []
        client.listener.on_point_distances(answers.append)
        description = client.node.create_publisher(String, '/robot_description', LATCHED)
        clouds = client.node.create_publisher(PointCloud2, '/scene_graph/query_points', 10)

        description.publish(String(data=PROBE))
        client.wait_for(lambda: client.scene().has('probe'), 'the robot')
        names = sorted(g.short_name for g in client.scene().geometries.values())
        print('the scene holds', ', '.join(names))

        # The tip is 0.2 m below the shaft's middle; the ball stays where the scene file put it.
        poses = {'shaft': [0.5, 0, 0.7, 0, 0, 0, 1], 'tip': [0.5, 0, 0.5, 0, 0, 0, 1]}
        # Two points in the tip's frame, 0.1 m and 0.2 m below it; the stamp names the cloud.
        cloud = cloud_of([(0.0, 0.0, -0.1), (0.0, 0.0, -0.2)], frame_id='tip', stamp_sec=7)

        def answers_at(height):
            """Pose the robot, and return the answers with the first point at that height."""
            client.publish_poses(poses, source='probe')
            clouds.publish(cloud)
            return [found for found in answers if is_for(found, 7.0, height)]

        (answer, *_) = client.wait_for(lambda: answers_at(0.5 - 0.1), 'an answer')
        for point in answer:
            print(f'point {point.point_index}: {point.distance:.4f} m from {point.name}')


def is_for(answer, stamp, height):
    """Tell whether an answer is for a cloud, with its first point at a height over the floor."""
    over_floor = [p.distance for p in answer.to('world/floor') if p.point_index == 0]
    return answer.query_stamp == stamp and over_floor and abs(over_floor[0] - height) < 1e-6


if __name__ == '__main__':
    main()
