"""What the demo leaves behind: results.csv, distances.png, closest.png and camera.png."""

from pathlib import Path

from drake_geom_ros.ros.demo.camera import draw_camera
from drake_geom_ros.ros.demo.picture import draw_closest
from drake_geom_ros.ros.demo.plots import draw_distances
from drake_geom_ros.ros.demo.recording import Recording, percentiles
from drake_geom_ros.ros.demo.results_csv import write_results
from drake_geom_ros.scene_files import SceneDescription


def write_report(
    recording: Recording, folder: Path, description: SceneDescription | None = None
) -> list[str]:
    """Write the files into a folder, made where it is missing; return what they hold, a line each.

    closest.png is left out where no two robots came near enough for a result, camera.png, too,
    where the scene has no camera.
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
    if recording.approach is not None:
        draw_closest(recording, folder / 'closest.png')
        moment = recording.approach
        name = recording.scene.pair_name(moment.id_a, moment.id_b)
        said.append(f'{folder / "closest.png"}: {name}, {moment.distance * 1e3:.2f} mm')
        if description and (seen := draw_camera(description, moment, folder / 'camera.png')):
            said.append(f'{folder / "camera.png"}: colour, depth and labels of the camera {seen}')
    cycle = percentiles(recording.cycle_seconds)
    age = percentiles([pairs.age for pairs in recording.pairs])
    said.append(
        f'cycle p50 {cycle[0] * 1e3:.2f} ms, p99 {cycle[1] * 1e3:.2f} ms; '
        f'age of the answer p50 {age[0] * 1e3:.2f} ms, p99 {age[1] * 1e3:.2f} ms'
    )
    return said
