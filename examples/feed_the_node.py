"""Feed a running node: a robot by its description, poses of its links, and points to measure.

Start the node with scenes/minimal.yaml and point_threshold 1.0 first, see docs/inputs.md.
"""

import array

import rclpy
from drake_geom_msgs.msg import FramePoses, PointDistances, Scene
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import String

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
    rclpy.init()
    node = rclpy.create_node('feed_the_node')
    names, answers = {}, []

    def keep_names(scene):
        frames = {frame.id: frame.name for frame in scene.frames}
        names.clear()
        names.update({g.id: f'{frames[g.frame_id]}/{g.name}' for g in scene.geometries})

    node.create_subscription(Scene, '/scene_graph/scene', keep_names, LATCHED)
    node.create_subscription(PointDistances, '/scene_graph/point_distances', answers.append, 10)
    description = node.create_publisher(String, '/robot_description', LATCHED)
    poses = node.create_publisher(FramePoses, '/scene_graph/frame_poses', 10)
    clouds = node.create_publisher(PointCloud2, '/scene_graph/query_points', 10)

    description.publish(String(data=PROBE))
    while 'tip/ball' not in names.values():
        rclpy.spin_once(node, timeout_sec=0.1)
    print('the scene holds', ', '.join(sorted(names.values())))

    # The tip is 0.2 m below the shaft's middle; the ball stays where the scene file put it.
    message = FramePoses(source='probe', frame_names=['shaft', 'tip'])
    for z in (0.7, 0.5):
        message.poses.extend([0.5, 0.0, z, 0.0, 0.0, 0.0, 1.0])
    # Two points in the tip's frame, 0.1 m and 0.2 m below it; the stamp names the cloud.
    cloud = cloud_of([(0.0, 0.0, -0.1), (0.0, 0.0, -0.2)], frame_id='tip', stamp_sec=7)
    tip_at = 0.5 - 0.1
    while not any(is_for(answer, cloud, names, tip_at) for answer in answers):
        poses.publish(message)
        clouds.publish(cloud)
        rclpy.spin_once(node, timeout_sec=0.1)
    answer = next(answer for answer in answers if is_for(answer, cloud, names, tip_at))
    rows = zip(answer.point_index, answer.id_g, answer.distance, strict=True)
    for point, geometry, distance in rows:
        print(f'point {point}: {distance:.4f} m from {names[geometry]}')
    node.destroy_node()
    rclpy.shutdown()


def is_for(answer, cloud, names, height):
    """Tell whether an answer is for a cloud, with its first point at a height over the floor."""
    if answer.query_stamp != cloud.header.stamp:
        return False
    rows = zip(answer.point_index, answer.id_g, answer.distance, strict=True)
    found = {(point, names[geometry]): distance for point, geometry, distance in rows}
    return abs(found.get((0, 'world/floor'), -1.0) - height) < 1e-6


if __name__ == '__main__':
    main()
