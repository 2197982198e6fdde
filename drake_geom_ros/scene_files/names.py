"""Names of frames and geometries in filters: text to member and back."""

from collections import defaultdict
from collections.abc import Iterable, Mapping

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import Role
from drake_geom_ros.scene_files.description import (
    WORLD,
    FrameDescription,
    GeometryDescription,
    Member,
)
from drake_geom_ros.scene_files.drake_names import drake_name
from drake_geom_ros.scene_files.errors import Location

MemberName = str | Mapping[str, str]


class FileNames:
    """Names of a scene's frames, and of its geometries with the proximity role.

    A frame is ``frame`` or ``source::frame``, a geometry ``frame/geometry`` or
    ``source::frame/geometry``, by its own name or else by Drake's. Names may contain ``::`` and
    ``/``: a text is looked up whole, and refused if it matches several members. Parts that are
    given by key (``source``, ``frame``, ``geometry``) are never ambiguous.
    """

    def __init__(
        self, frames: Iterable[FrameDescription], geometries: Iterable[GeometryDescription]
    ):
        self._members: defaultdict[str, dict[Member, None]] = defaultdict(dict)
        self._by_drake_name: defaultdict[str, dict[Member, None]] = defaultdict(dict)
        self._members[WORLD] = {Member('', WORLD): None}
        for frame in frames:
            self._add(frame.name, Member(frame.source, frame.name))
        for geometry in geometries:
            if Role.kProximity in geometry.roles:
                member = Member(geometry.source, geometry.frame, geometry.name)
                self._add(f'{geometry.frame}/{geometry.name}', member)
                if name := drake_name(geometry.roles[Role.kProximity]):
                    short = f'{geometry.frame}/{name}'
                    for text in (short, f'{geometry.source}::{short}'):
                        self._by_drake_name[text][member] = None

    def _add(self, short: str, member: Member) -> None:
        self._members[short][member] = None
        self._members[f'{member.source}::{short}'][member] = None

    def _called(self, name: str) -> list[Member]:
        """Return the members of that name; Drake's names count where no own name is equal."""
        table = self._members if self._members.get(name) else self._by_drake_name
        return list(table.get(name, ()))

    def find(self, name: MemberName, place: Location) -> Member:
        """Return the member of a name; SceneFileError if none or several match."""
        if isinstance(name, Mapping):
            return self._find_parts(name, place)
        members = self._called(name)
        if len(members) == 1:
            return members[0]
        if not members:
            raise place.error(
                f'{name!r} is neither a frame nor a geometry with the proximity role of this scene'
                + nearest(name, self._members)
            )
        longer = ', '.join(f'{_full_name(member)!r}' for member in members)
        raise place.error(
            f'{name!r} matches several: {longer}; give the source, or the parts as '
            '{source: ..., frame: ..., geometry: ...}'
        )

    def _find_parts(self, parts: Mapping[str, str], place: Location) -> Member:
        member = Member(parts['source'], parts['frame'], parts.get('geometry'))
        if member in self._members.get(_full_name(member), ()):
            return member
        of_drake = self._by_drake_name.get(_full_name(member), {})
        if same := [m for m in of_drake if (m.source, m.frame) == (member.source, member.frame)]:
            return same[0]
        raise place.error(f'{_full_name(member)!r} is not in this scene')

    def name(self, member: Member) -> MemberName:
        """Return the name that ``find`` turns back into the member."""
        text = _full_name(member)
        if len(self._members[text]) == 1:
            return text
        parts = {'source': member.source, 'frame': member.frame}
        return parts if member.geometry is None else {**parts, 'geometry': member.geometry}


def _full_name(member: Member) -> str:
    frame = f'{member.source}::{member.frame}' if member.source else member.frame
    return frame if member.geometry is None else f'{frame}/{member.geometry}'
