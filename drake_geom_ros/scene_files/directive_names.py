"""Names of model directives: models, and frames that are links or fixed to links."""

from dataclasses import dataclass, field

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import WORLD, Member
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.robot_parts import RobotParts

SCOPE = '::'


@dataclass(frozen=True)
class LinkFrame:
    """A frame F that is fixed to a link L, or to the world, with X_LF."""

    link: Member
    X_LF: RigidTransform = field(default_factory=RigidTransform)


def scoped(namespace: str, name: str) -> str:
    """Return a name in a namespace, either of which may be empty; the world is in none."""
    return name if name == WORLD else SCOPE.join(filter(None, (namespace, name)))


def namespace_of(name: str) -> str:
    """Return all but the last part of a scoped name."""
    return name.rpartition(SCOPE)[0]


class ScopedFrames:
    """The frames of models that were added, and of the directives themselves, by scoped name."""

    def __init__(self) -> None:
        self._frames: dict[str, LinkFrame] = {WORLD: LinkFrame(Member('', WORLD))}

    def add_model(self, source: str, parts: RobotParts) -> None:
        """Add the links and named frames of a model."""
        for link in parts.link_names:
            self._frames[scoped(source, link)] = LinkFrame(Member(source, link))
        for name, (link, X_LF) in parts.offsets.items():
            member = Member('', WORLD) if link == WORLD else Member(source, link)
            self._frames[scoped(source, name)] = LinkFrame(member, X_LF)

    def add(self, name: str, frame: LinkFrame, where: Location) -> None:
        """Add a frame of a directive; raises SceneFileError if there is one of the name."""
        if name in self._frames:
            raise where.error(f'there is a frame {name!r} already')
        self._frames[name] = frame

    def find(self, name: str, where: Location) -> LinkFrame:
        """Return a frame by its scoped name, or by the last part of it if no other has it.

        Raises SceneFileError for a name that is missing or ambiguous.
        """
        if name in self._frames:
            return self._frames[name]
        matches = [full for full in self._frames if full.endswith(SCOPE + name)]
        if SCOPE not in name and len(matches) == 1:
            return self._frames[matches[0]]
        if SCOPE not in name and matches:
            shown = ', '.join(map(repr, matches))
            raise where.error(f'{name!r} is the name of several frames: {shown}')
        raise where.error(f'there is no frame {name!r} so far{nearest(name, self._frames)}')

    def link(self, name: str, where: Location) -> Member:
        """Return a link by its name; raises SceneFileError if it is no link."""
        frame = self.find(name, where)
        if not frame.X_LF.IsExactlyIdentity() or frame.link.frame == WORLD:
            raise where.error(f'{name!r} is not a link')
        return frame.link
