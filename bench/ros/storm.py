"""Faults in a row: `./run soak --faults 1000` does them, and compares the scene after each.

A node with two arms, to which poses stream, a subscriber that never reads and hostile messages as
in the soak, and nobody who may change the scene. After each fault the node has to answer, and its
scene has to be what it was before the first: the saved text, the filters, and the distances of all
pairs at poses that are given. A fault is done again by its number: ``--faults 1 --first 523``.
The exit code is 1 where anything was not as expected.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from drake_geom_msgs import msg, srv
from numpy.typing import NDArray

from bench.ros.driver import SERVER, Driver, Soak, start_node, start_player
from bench.ros.faults.order import Faults, listed
from bench.ros.faults.site import NodeDiedError, Site
from bench.ros.processes import Processes, memory
from bench.ros.scenes import two_arms

SHOWN = 20  # problems listed
WARM_UP = 5.0  # [s]
SETTLE = 30.0  # [s] in which DDS gives up those who died, and what was kept for them
EVERY = 50  # faults, after which what the node takes is printed


class Scene(NamedTuple):
    """What must not change."""

    entries: object  # of the saved scene, without the poses of frames, which stream in
    filters: tuple[int, ...]
    ids: NDArray[np.uint64]  # (n, 2) of all pairs
    distances: NDArray[np.float64]  # (n,) [m] at given poses
    bounds: NDArray[np.float64]  # (n,) [m] of their errors

    def difference(self, other: Scene) -> str:
        """Return in words what another scene does not share; empty: it is the same."""
        if self.entries != other.entries:
            return 'the saved scene is another'
        if self.filters != other.filters:
            return f'the filters were {self.filters} and are {other.filters}'
        if not np.array_equal(self.ids, other.ids):
            return f'the pairs are others: {len(self.ids)} before, {len(other.ids)} now'
        apart = np.abs(self.distances - other.distances)
        worst = int((apart - self.bounds - other.bounds).argmax())
        if apart[worst] > self.bounds[worst] + other.bounds[worst]:
            return f'the distance of {self.ids[worst]} differs by {apart[worst]} m'
        return ''


def scene_of(site: Site) -> Scene:
    """Ask the node for its scene."""
    played = two_arms()
    text = site.ask(srv.SaveScene, f'{SERVER}/save_scene').text
    entries = yaml.load(text, Loader=getattr(yaml, 'CSafeLoader', yaml.SafeLoader))
    for frame in entries['frames']:
        for key in ('pose', 'static'):  # `static: false` is said beside a pose
            frame.pop(key, None)
    filters = site.ask(srv.GetFilters, f'{SERVER}/get_filters')
    service = f'{SERVER}/compute_signed_distance_pairwise'
    poses = msg.FramePoses(frame_names=played.frame_names, poses=played.poses(0.0).ravel())
    answer = site.ask(srv.ComputeSignedDistancePairwise, service, poses=poses)
    if not answer.success:
        raise RuntimeError(f'{service} says {answer.message}')
    found = answer.result
    return Scene(
        entries,
        (filters.filtered_pairs, *filters.active_filter_ids),
        np.stack([found.id_a, found.id_b], axis=1),
        np.array(found.distance),
        np.array(found.error_bound),
    )


def costs(pid: int) -> str:
    """Return what a process takes, in words."""
    descriptors, threads = (len(os.listdir(f'/proc/{pid}/{what}')) for what in ('fd', 'task'))
    return f'{memory(pid):.0f} MB, {descriptors} descriptors, {threads} threads'


def run(options: argparse.Namespace, folder: Path) -> int:
    """Do faults, print what came of them, and return the exit code."""
    problems: list[str] = []
    with Processes() as processes:
        node = start_node(processes, folder)
        driver = Driver(Soak(), 0, options.seed)
        start_player(processes, options.rate)
        processes.start('bench.ros.deaf')
        site = Site(driver.node, driver.spin, processes, node, SERVER, folder)
        driver.spin(WARM_UP)
        before = scene_of(site)
        print(f'before: {len(before.ids)} pairs, {costs(node.pid)}', flush=True)
        faults = Faults(site, options.seed, options.first)
        start = time.monotonic()
        try:
            for done in range(1, options.faults + 1):
                found = faults.do_one()
                if difference := before.difference(scene_of(site)):
                    found.append(f'after fault {options.first + done - 1}: {difference}')
                problems += found
                print(''.join(f'  PROBLEM {problem}\n' for problem in found), end='', flush=True)
                if done % EVERY == 0:
                    print(f'after {done} faults: {costs(node.pid)}', flush=True)
        except NodeDiedError as error:
            problems.append(str(error))
        minutes = (time.monotonic() - start) / 60.0
        if node.poll() is None:
            driver.spin(SETTLE)
            print(f'{SETTLE:g} s later: {costs(node.pid)}')
    print(f'{faults.counts.total()} faults in {minutes:.1f} minutes: {listed(faults.counts)}')
    print(f'the scene was compared after each; {len(problems)} problems')
    for problem in problems[:SHOWN]:
        print(f'  {problem}')
    return 1 if problems else 0
