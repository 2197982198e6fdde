"""Pictures of the closest moments."""

from __future__ import annotations

from io import BytesIO

from drake_geom_ros.geometry import GeometryId, QueryObject, Role
from drake_geom_ros.proximity_rules import geometry_names
from drake_geom_ros.recordings.results import RunAnalysis
from drake_geom_ros.recordings.set_clearance import Moment
from drake_geom_ros.viewing.shown_pairs import ReportedPairs
from drake_geom_ros.viewing.snapshot import camera_for, picture

_SIZE, _FOV_Y = (640, 420), 0.6  # [pixels], [rad]
_SEE_THROUGH = 0.6


def pictures_of(run: RunAnalysis, count: int) -> dict[tuple[str, int], bytes]:
    """Return PNGs by the name of a set and the number of a moment, the closest one being 1.

    Moments in which a frame has no pose get no picture.
    """
    return {
        (name, number): _picture(query, close.moment)
        for name, moments in run.moments.items()
        for number, close in enumerate(moments[:count], 1)
        if (query := close.scene()) is not None
    }


def _picture(query: QueryObject, moment: Moment) -> bytes:
    from PIL import Image

    inspector = query.inspector()
    ids = [GeometryId(value) for value in inspector.candidate_matrix()[0].tolist()]
    named = {geometry_names(inspector, each).full_name: each for each in ids}
    pair = query.signed_distance_of_pair(named[moment.name_A], named[moment.name_B])
    camera = camera_for(query, Role.kProximity, _SIZE, _FOV_Y)
    pixels = picture(query, camera, see_through=_SEE_THROUGH, pairs=ReportedPairs.of(pair))
    file = BytesIO()
    Image.fromarray(pixels).save(file, 'PNG')
    return file.getvalue()
