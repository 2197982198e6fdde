"""An arm keeps its distance from a thing that is in no scene file: a depth camera sees it.

``./run demo --sensed`` starts a node with the demo's two arms. A ball hangs where the
left hand is to go; the model has none. Images of a camera on a mast, rendered of the arms, their
objects and the ball, go to the node, which leaves out what it knows. The arm goes on only while
results say that it is far enough from what was seen. Left is sensed.png: the distance that the
node published, the true one, and what it would have become.
"""

import argparse
import array
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import rclpy
from drake_geom_msgs.msg import FramePoses, Scene, Shape, SignedDistancePairs
from matplotlib.figure import Figure
from numpy.typing import NDArray
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo as CameraInfoMessage
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryInstance,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.ros.demo.processes import ProcessGroup, ros_environment
from drake_geom_ros.ros.demo.shipped_scenes import shipped_scene
from drake_geom_ros.scene_files import (
    CameraDescription,
    add_renderers,
    camera_of,
    load_scene,
    read_scene,
)
from drake_geom_ros.sensors import CameraInfo
from drake_geom_ros.trajectories.motion_file import load_motion

_KEEP = 0.15  # [m]
_RADIUS = 0.06  # [m] of the ball
_WHERE = 1.8  # [s] of the motion: the ball hangs where the left hand is then
_STEP = 0.02  # [s] of the motion, a step of the arm
_PATIENCE = 300.0  # [s] until the node answers: it may have to compile

Floats = NDArray[np.float64]


class Step(NamedTuple):
    """A moment of the run: the motion's time [s], and the published and true distances [m]."""

    time: float
    published: float
    true: float


class World:
    """The scene of the file and the ball, as they really are; a camera sees all of it."""

    def __init__(self) -> None:
        self.file = shipped_scene('two_pandas.yaml')
        description = read_scene(self.file)
        self.motion = load_motion(shipped_scene('two_pandas_motion.yaml'), description)
        self._graph = SceneGraph()
        self._loaded = load_scene(self.file, self._graph)
        add_renderers(self._graph)
        self.p_WB = self._hand(_WHERE)
        source = self._graph.RegisterSource('unknown')
        ball = GeometryInstance(RigidTransform(self.p_WB), Sphere(_RADIUS), 'ball')
        ball.set_proximity_properties(ProximityProperties())
        self._ball = self._graph.RegisterAnchoredGeometry(source, ball)
        self._context = self._graph.CreateSharedContext(partial=True)
        self._query = self._graph.get_query_output_port().Eval(self._context)
        self.X_WC = _looking(np.array([0.1, -1.3, 1.4]), self.p_WB)
        intrinsics = CameraInfo(320, 240, np.pi / 4)
        self._camera = CameraDescription(
            *('eye', 'mast', 'eye', RigidTransform(), intrinsics, (0.1, 5.0)),
            images=('depth',),
            shows='proximity',
        )

    @property
    def intrinsics(self) -> CameraInfo:
        """The camera's."""
        return self._camera.intrinsics

    def _hand(self, t: float) -> Floats:
        names = list(self.motion.frame_names['left'])
        return np.asarray(self.motion.poses(t)['left'][names.index('panda_hand'), :3])

    def poses(self, t: float) -> tuple[list[str], Floats]:
        """Return the names of the frames that move and their poses (n, 7) at a time [s]."""
        poses = self.motion.poses(t)
        names = [f'{s}::{name}' for s, all in self.motion.frame_names.items() for name in all]
        return names, np.concatenate([poses[source] for source in self.motion.frame_names])

    def move(self, t: float) -> None:
        """Pose what is there as at a time [s] of the motion."""
        names, rows = self.poses(t)
        ids = [self._loaded.frames[tuple(name.split('::'))] for name in names]  # type: ignore[index]
        self._context.UpdateFramePoses(FramePoseVector.FromArrays(ids, rows))

    def depth(self) -> NDArray[np.float32]:
        """Return the depths (h, w) [m] that the camera sees."""
        world = self._graph.world_frame_id()
        images = self._query.render_images(camera_of(self._camera), world, self.X_WC)
        assert images.depth is not None
        return np.asarray(images.depth.data[..., 0])

    def clearance(self) -> float:
        """Return how far [m] the left arm really is from the ball."""
        distances = self._query.ComputeSignedDistancePairwiseClosestPoints(2.0)
        ball = self._ball.get_value()
        of_ball = (distances.id_A == ball) | (distances.id_B == ball)
        own = [name.startswith('left::') for name in self._others(distances, ball)]
        return float(distances.distance[of_ball & np.array(own)].min())

    def _others(self, distances: Any, ball: int) -> list[str]:
        inspector = self._graph.model_inspector()
        ids = {id.get_value(): id for id in inspector.GetAllGeometryIds()}
        others = np.where(distances.id_A == ball, distances.id_B, distances.id_A)
        names = {}
        for value in set(others.tolist()):
            names[value] = f'{inspector.GetOwningSourceName(ids[value])}::'
        return [names[value] for value in others.tolist()]


def _looking(p_WC: Floats, at: Floats) -> RigidTransform:
    """Return the pose of a camera (z ahead, x right, y down) that looks at a point."""
    z = (at - p_WC) / np.linalg.norm(at - p_WC)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return RigidTransform(RotationMatrix(np.column_stack([x, np.cross(z, x), z])), p_WC)


class Driver:
    """Sends poses and images to the node, and reads how far away it says that things are."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._node = rclpy.create_node('sensed_demo')
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._maps: set[int] = set()
        self._arm: set[int] = set()
        self._last: SignedDistancePairs | None = None
        topic = '/scene_graph/obstacles/depth'
        self._poses = self._node.create_publisher(FramePoses, '/scene_graph/frame_poses', 5)
        self._images = self._node.create_publisher(Image, f'{topic}/image_rect_raw', 5)
        self._infos = self._node.create_publisher(CameraInfoMessage, f'{topic}/camera_info', 5)
        self._node.create_subscription(Scene, '/scene_graph/scene', self._learn, latched)
        self._node.create_subscription(
            SignedDistancePairs, '/scene_graph/signed_distances', self._hear, 10
        )

    def _learn(self, scene: Scene) -> None:
        sources = {source.id: source.name for source in scene.sources}
        for geometry in scene.geometries:
            if geometry.shape.type == Shape.OCCUPIED_CELLS:
                self._maps.add(geometry.id)
            elif sources[geometry.source_id] == 'left':
                self._arm.add(geometry.id)

    def _hear(self, pairs: SignedDistancePairs) -> None:
        self._last = pairs

    def step(self, t: float) -> float | None:
        """Show the node the world at a time [s] of the motion.

        Return the distance [m] that it publishes: None where it has no map yet, inf where nothing
        seen is near the arm.
        """
        self._world.move(t)
        stamp = self._node.get_clock().now().to_msg()
        names, rows = self._world.poses(t)
        header = Header(stamp=stamp, frame_id='world')
        self._poses.publish(
            FramePoses(header=header, frame_names=names, poses=rows.ravel().tolist())
        )
        self._send_image(Header(stamp=stamp, frame_id='mast::eye'))
        end = time.monotonic() + 0.1
        while (left := end - time.monotonic()) > 0.0:
            rclpy.spin_once(self._node, timeout_sec=left)
        last = self._last
        if last is None or not self._maps or any('obstacles' in n for n in last.waiting_frames):
            return None
        rows_of = zip(last.id_a, last.id_b, last.distance, strict=True)
        pairs = ((d, {a, b}) for a, b, d in rows_of)
        return min((d for d, ids in pairs if ids & self._maps and ids & self._arm), default=np.inf)

    def _send_image(self, header: Header) -> None:
        depth = np.where(np.isfinite(self._world.depth()), self._world.depth(), 0.0)
        k = self._world.intrinsics
        # In ROS the middle of pixel u is at u, in Drake at u + 0.5.
        matrix = [k.focal_x(), 0.0, k.center_x() - 0.5]
        matrix += [0.0, k.focal_y(), k.center_y() - 0.5, 0.0, 0.0, 1.0]
        size = {'width': k.width(), 'height': k.height()}
        self._infos.publish(CameraInfoMessage(header=header, k=matrix, **size))
        data = array.array('B', depth.astype('<f4').tobytes())
        fields = {'encoding': '32FC1', 'step': 4 * k.width(), 'data': data}
        self._images.publish(Image(header=header, **size, **fields))


def run(out: Path) -> list[Step]:
    """Let the arm go until it comes too near; return the steps, and draw them."""
    world = World()
    X = world.X_WC.ToArray()
    p, q = X[:3].tolist(), X[3:].tolist()
    out.mkdir(parents=True, exist_ok=True)
    scene = out / 'sensed.yaml'
    # The file of the arms, and the mast: no ball.
    lines = world.file.read_text().replace(
        'sources: [left, right, objects, scenery]',
        'sources: [left, right, objects, scenery, mast]',
    )
    pose = f'{{position: {p}, quaternion: {q}}}'
    eye = f'  - {{name: eye, source: mast, static: true, pose: {pose}}}\n'
    scene.write_text(lines.replace('frames:\n', f'frames:\n{eye}', 1))
    settings = ['obstacles:=[depth]', 'obstacle_self_filter:=scene', 'obstacle_resolution:=0.02']
    settings += [f'scene_file:={scene}', 'max_distance:=0.6', 'obstacle_padding:=0.03']
    arguments = [word for each in settings for word in ('-p', each)]
    steps: list[Step] = []
    with ProcessGroup(ros_environment()) as processes:
        node = 'drake_geom_ros.ros.scene_graph_node'
        processes.start('node', node, '--ros-args', *arguments, log=out / 'sensed_node.log')
        rclpy.init()
        driver = Driver(world)
        end = time.monotonic() + _PATIENCE
        while driver.step(0.0) is None:
            if time.monotonic() > end:
                raise RuntimeError(f'no map after {_PATIENCE:g} s; see {out}/sensed_node.log')
        t = 0.0
        held = 0
        while t < _WHERE and held < 10:
            published = driver.step(t)
            assert published is not None, 'a map that was there is never forgotten by itself'
            steps.append(Step(t, published, world.clearance()))
            if published > _KEEP:
                t, held = t + _STEP, 0
            else:
                held += 1
        rclpy.shutdown()
    draw(world, steps, out / 'sensed.png')
    return steps


def draw(world: World, steps: list[Step], path: Path) -> None:
    """Draw what the camera saw at the end, and the distances over the motion's time."""
    figure = Figure(figsize=(12.0, 4.5), layout='constrained')
    image, plot = figure.subplots(1, 2)
    world.move(steps[-1].time)
    depth = world.depth()
    shown = image.imshow(np.where(np.isfinite(depth), depth, np.nan), cmap='viridis_r')
    figure.colorbar(shown, ax=image, label='depth [m]')
    image.set_title('what the camera sees where the arm stays')
    image.set_axis_off()
    times = np.arange(0.0, _WHERE, _STEP)
    would = []
    for t in times:
        world.move(float(t))
        would.append(world.clearance())
    plot.plot(times, would, ':', color='tab:gray', label='true, had it gone on')
    plot.plot([s.time for s in steps], [s.true for s in steps], label='true')
    plot.plot(
        [s.time for s in steps], [s.published for s in steps], '.', label='published by the node'
    )
    plot.axhline(_KEEP, color='black', linewidth=0.8, label='limit')
    plot.set_xlabel('time of the motion [s]')
    plot.set_ylabel('left arm to what was seen [m]')
    plot.set_ylim(bottom=min(0.0, *would))
    plot.legend()
    figure.savefig(path, dpi=100)


def show(out: Path) -> None:
    """Run, and print where the arm stayed."""
    steps = run(out)
    last = steps[-1]
    print(
        f'the arm stays at {last.time:.2f} s of its motion: the node publishes '
        f'{last.published:.3f} m to what was seen, {last.true:.3f} m are true, and {_KEEP:g} m '
        f'are to be kept; see {out / "sensed.png"}'
    )


def main() -> None:
    """Show it."""
    parser = argparse.ArgumentParser(prog='demo.sensed', description=__doc__.splitlines()[0])
    parser.add_argument('--out', type=Path, default=Path('out/sensed'), help='folder of the files')
    show(parser.parse_args().out)


if __name__ == '__main__':
    main()
