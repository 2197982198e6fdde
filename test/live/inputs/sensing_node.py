"""A live scene with one input of a sensed map, and messages that it takes. No ROS."""

import array
from functools import partial
from types import SimpleNamespace as Plain

import numpy as np
from live.live_scenes import Clock, live_scene

from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.live.inputs.obstacle_records import ObstacleSettings
from drake_geom_ros.live.inputs.obstacle_sources import age_limits, settings_of
from drake_geom_ros.live.inputs.obstacles import ObstacleInput
from drake_geom_ros.live.inputs.point_taker import PointTaker
from drake_geom_ros.live.inputs.sensor_frames import SensorFrames
from drake_geom_ros.live.scene.feeders import MESSAGES
from drake_geom_ros.live.scene.map_placing import map_ages, stand_fed
from drake_geom_ros.live.scene.map_sources import MapSources
from drake_geom_ros.live.scene.pose_history import PoseHistory
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import ObstacleSource

SCENE = """
sources: [s]
frames:
- {name: arm, source: s}
- {name: eye, source: s, parent: arm, pose: {position: [0, 0, 1]}, static: true}
- {name: mast, source: s, pose: {position: [0, 0, 2]}, static: true}
geometries:
- {name: hand, source: s, frame: arm, shape: {type: sphere, radius: 0.1}}
- {name: post, source: s, shape: {type: box, size: [0.1, 0.1, 1]}, pose: {position: [3, 0, 0]}}
"""
USUAL = ObstacleSettings(
    resolution=0.1, reach=5.0, padding=0.05, noise=0.01, self_filter='scene', least_points=1,
    keep=0.0, rays=False, margin=0.0,
)  # fmt: skip


class Node:
    """A live scene with one input, and clocks that the test sets."""

    def __init__(self, name='points', tf=None, scene=SCENE, source=None, **changes):
        source = source or ObstacleSource(name, 'point_cloud', f'~/obstacles/{name}')
        self.clock = Clock(100.0)
        self.live = live_scene(scene, self.clock)
        self.settings = USUAL._replace(**changes)
        self.changes = 0
        self.name = name = source.name
        self.tf = tf(self.live.clocks) if tf else None
        self.frames = frames = SensorFrames(lambda: self.tf)
        self.input = ObstacleInput(
            source,
            self.live,
            lambda: settings_of(source, self.settings),
            frames,
            self._note_change,
        )
        self.taker = PointTaker(self.input)
        self.live.map_sources = MapSources({name: self.input})
        with self.live.editing() as held:
            held.poses.history = PoseHistory()
            held.maps.stand = partial(stand_fed, sources=self.live.map_sources)
            held.maps.limits = age_limits({name: source})
            held.maps.stand(held)

    def add(self, source):
        """Add an input of one more source, and return it with what takes its points."""
        added = ObstacleInput(
            source,
            self.live,
            lambda: settings_of(source, self.settings),
            SensorFrames(lambda: self.tf),
            self._note_change,
        )
        self.live.map_sources = MapSources({**self.live.map_sources.fed, source.name: added})
        with self.live.editing() as held:
            held.maps.stand = partial(stand_fed, sources=self.live.map_sources)
            held.maps.limits = {**held.maps.limits, **age_limits({source.name: source})}
            held.maps.stand(held)
        return added, PointTaker(added)

    def _note_change(self):
        self.changes += 1

    def move(self, stamp, position, yaw=0.0):
        """Pose the arm, by a message of a stamp."""
        with self.live.editing() as scene:
            arm = scene.model.names.frame('arm')
            X = RigidTransform(RollPitchYaw(0.0, 0.0, yaw), position)
            poses = FramePoseVector({arm: X})
            since = scene.clocks.arrival().since(stamp)
            posed = {frozenset([arm.get_value()]): since}
            rows = X.ToArray()[np.newaxis]
            scene.poses.pose(poses, posed, stamp_of(stamp), MESSAGES, rows)

    def centres(self):
        """Return the centres of the cells in the world."""
        with self.live.reading() as scene:
            known = scene.maps.by_name[self.name]
            if known.cells is None:
                return None
            shape = scene.model.inspector.GetShape(known.geometry)
            assert shape.centres().tolist() == known.cells.centres().tolist()
            return scene.query.X_WF(known.frame).multiply(shape.centres().T).T

    def age(self):
        with self.live.reading() as scene:
            return map_ages(scene)[self.name]

    def pairs(self):
        """Return names and distances of all pairs, and how many wait."""
        with self.live.reading() as scene:
            found = scene.query.ComputeSignedDistancePairwiseClosestPoints()
            names = {g.get_value(): n for g, n in scene.model.names.geometry_names.items()}
            rows = zip(found.id_A, found.id_B, found.distance, strict=True)
            told = {frozenset((names[a], names[b])): d for a, b, d in rows}
            return told, scene.waiting().pairs


def stamp_of(seconds):
    return Plain(sec=int(seconds), nanosec=round((seconds % 1) * 1e9))


def header(frame, stamp):
    return Plain(frame_id=frame, stamp=stamp_of(stamp))


def cloud(points, frame='mast', stamp=100.0, **changes):
    rows = np.asarray(points, dtype='<f4').reshape(-1, 3)
    fields = [Plain(name=a, offset=4 * k, datatype=7, count=1) for k, a in enumerate('xyz')]
    told = {
        'header': header(frame, stamp), 'width': len(rows), 'height': 1, 'fields': fields,
        'is_bigendian': False, 'point_step': 12, 'row_step': 12 * len(rows),
        'data': array.array('B', rows.tobytes()),
    }  # fmt: skip
    return Plain(**{**told, **changes})


def scan(ranges, frame='mast', stamp=100.0, **changes):
    """Return a LaserScan: by default rays over a half turn to the front, without a duration."""
    told = {
        'header': header(frame, stamp), 'ranges': array.array('f', ranges), 'range_min': 0.05,
        'range_max': 10.0, 'angle_min': -np.pi / 2, 'angle_max': np.pi / 2,
        'angle_increment': np.pi / max(1, len(ranges) - 1), 'time_increment': 0.0,
        'scan_time': 0.0, 'intensities': array.array('f'),
    }  # fmt: skip
    return Plain(**{**told, **changes})


def cone(distance, frame='mast', stamp=100.0, **changes):
    """Return a Range of a narrow cone."""
    told = {
        'header': header(frame, stamp), 'radiation_type': 0, 'field_of_view': 0.02,
        'min_range': 0.05, 'max_range': 4.0, 'range': distance,
    }  # fmt: skip
    return Plain(**{**told, **changes})


def grid(points, stamp=100.0, frame='world', value=100, **changes):
    """Return an OccupancyGrid of 60 by 40 cells of 0.1 m from (-2, -2) on, occupied at points."""
    cells = np.zeros((40, 60), dtype=np.int8)
    for x, y, *_ in points:
        cells[int((y + 2.0) // 0.1), int((x + 2.0) // 0.1)] = value
    origin = Plain(
        position=Plain(x=-2.0, y=-2.0, z=0.0), orientation=Plain(x=0.0, y=0.0, z=0.0, w=1.0)
    )
    info = Plain(resolution=0.1, width=60, height=40, origin=origin)
    told = {'header': header(frame, stamp), 'info': info, 'data': array.array('b', cells.ravel())}
    return Plain(**{**told, **changes})
