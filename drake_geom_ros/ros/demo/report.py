"""The files that the demo leaves: results.csv, distances.png, closest.png and camera.png."""

import csv
from pathlib import Path

from drake_geom_ros.ros.demo.camera import draw_camera
from drake_geom_ros.ros.demo.picture import draw_closest
from drake_geom_ros.ros.demo.plots import draw_distances
from drake_geom_ros.ros.demo.recording import COLUMNS, Recording, percentiles
from drake_geom_ros.scene_files import SceneDescription


def write_report(
    recording: Recording, folder: Path, description: SceneDescription | None = None
) -> list[str]:
    """Write the files into a folder, made where it is missing; return what they hold, a line each.

    closest.png and camera.png need the description of the scene, and are left out where no two
    robots came near enough for a result; camera.png, too, where the scene has no camera.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rows = write_results(recording, folder / 'results.csv')
    said = [f'{folder / "results.csv"}: {rows} rows of {len(recording.pairs)} results']
    draw_distances(recording, folder / 'distances.png')
    deepest = max((contact.depth for contact in recording.contacts), default=0.0)
    said.append(
        f'{folder / "distances.png"}: deepest penetration {deepest * 1e3:.2f} mm, '
        f'{len(recording.changes)} filter changes'
    )
    if recording.approach is not None and description is not None:
        draw_closest(recording, description, folder / 'closest.png')
        moment = recording.approach
        name = recording.scene.pair_name(moment.id_a, moment.id_b)
        said.append(f'{folder / "closest.png"}: {name}, {moment.distance * 1e3:.2f} mm')
        if seen := draw_camera(description, moment, folder / 'camera.png'):
            said.append(f'{folder / "camera.png"}: colour, depth and labels of the camera {seen}')
    cycle = percentiles(recording.cycle_seconds)
    age = percentiles([pairs.age for pairs in recording.pairs])
    said.append(
        f'cycle p50 {cycle[0] * 1e3:.2f} ms, p99 {cycle[1] * 1e3:.2f} ms; '
        f'age of the answer p50 {age[0] * 1e3:.2f} ms, p99 {age[1] * 1e3:.2f} ms'
    )
    return said


def write_results(recording: Recording, path: Path) -> int:
    """Write the file and return the number of its rows.

    ``time`` [s] counts from the first result; ``distance`` and ``error_bound`` [m] are those of
    ~/signed_distances, ``depth`` [m] that of ~/penetrations for the same poses, empty where the
    pair does not penetrate; ``method`` is a METHOD_* constant, ``age`` [s] the answer's.
    """
    rows = 0
    with open(path, 'w', newline='', encoding='utf-8') as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for pairs in recording.pairs:
            for k in range(len(pairs.distance)):
                a, b = int(pairs.id_a[k]), int(pairs.id_b[k])
                depth = recording.depth_of.get((pairs.time, a, b))
                writer.writerow(
                    [
                        f'{pairs.time - recording.start:.4f}',
                        recording.scene[a].full_name,
                        recording.scene[b].full_name,
                        f'{pairs.distance[k]:.9g}',
                        '' if depth is None else f'{depth:.9g}',
                        f'{pairs.error_bound[k]:.3g}',
                        int(pairs.method[k]),
                        f'{pairs.age:.6f}',
                    ]
                )
                rows += 1
    return rows
