"""Pictures of the closest moments, by a second look at the recording up to the last of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from io import BytesIO
from typing import NamedTuple

from drake_geom_ros.geometry import FramePoseVector, GeometryId, QueryObject, Role
from drake_geom_ros.recordings.opened import Opened
from drake_geom_ros.recordings.player import Player
from drake_geom_ros.recordings.results import Moment
from drake_geom_ros.recordings.states import Block, StateBlocks
from drake_geom_ros.ros.scene.scene_rules import geometry_names
from drake_geom_ros.viewing.pairs import Pairs
from drake_geom_ros.viewing.snapshot import camera_for, picture

_SIZE, _FOV_Y = (640, 420), 0.6  # [pixels], [rad]
_SEE_THROUGH = 0.6


class Wanted(NamedTuple):
    """A moment of which there is to be a picture."""

    name: str  # of the set of pairs
    number: int  # of the moment, the closest one being 1
    moment: Moment


def pictures_of(
    opened: Opened, wanted: Mapping[int, Sequence[Wanted]], rate: float
) -> dict[tuple[str, int], bytes]:
    """Return PNGs by the name of a set and the number of a moment; ``wanted`` are by state.

    Of states in which a frame waits for a pose there is none: nobody knows where that is.
    """
    player = Player(opened, StateBlocks(opened.playback, ()), rate)
    found: dict[tuple[str, int], bytes] = {}
    first, last = 0, max(wanted, default=-1)
    if last < 0:
        return found
    for block in player.blocks():
        for state in range(first, first + len(block.times)):
            for each in wanted.get(state, ()):
                if not block.waiting:
                    pixels = _picture(block, state - first, each.moment)
                    found[each.name, each.number] = pixels
        first += len(block.times)
        if first > last:
            break
    return found


def _picture(block: Block, row: int, moment: Moment) -> bytes:
    from PIL import Image

    context = block.context.what_if()
    context.UpdateFramePoses(FramePoseVector.FromArrays(block.frames, block.poses[row]))
    query = QueryObject(context)
    inspector = query.inspector()
    ids = [GeometryId(value) for value in inspector.candidate_matrix()[0].tolist()]
    named = {geometry_names(inspector, each).full_name: each for each in ids}
    pair = query.signed_distance_of_pair(named[moment.name_A], named[moment.name_B])
    camera = camera_for(query, Role.kProximity, _SIZE, _FOV_Y)
    pixels = picture(query, camera, see_through=_SEE_THROUGH, pairs=Pairs.of(pair))
    file = BytesIO()
    Image.fromarray(pixels).save(file, 'PNG')
    return file.getvalue()
