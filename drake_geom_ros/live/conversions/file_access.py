"""Access to files on behalf of other nodes: the parameter ``mesh_roots``.

What comes through a service or a topic may name files: meshes, scene files, URDF and SRDF, and the
file that a scene is saved to. Those must lie in the folders of ``mesh_roots`` or beside the
node's own ``scene_file``, or, to be read, in ``package_roots``, where packages are looked for
first; a link in one of them is followed to read, as colcon installs by links, and never to write
elsewhere. Folders alone are written to through a link, files never. In ``mesh_roots``,
``package://`` stands for the share folders of all packages, and a relative folder counts from the
working folder of the node.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.scene_files import ResourceResolver, share_folders

ALL_PACKAGES = 'package://'


class FileAccess:
    """The folders that files may be opened in."""

    def __init__(
        self,
        mesh_roots: Sequence[str],
        scene_file: str = '',
        package_roots: Sequence[str] = (),
        *,
        writes: bool = True,
    ) -> None:
        """Take the values of the parameters; ``writes``: files may be written there, too."""
        self._writes = writes
        self.package_roots = [Path(root).absolute() for root in package_roots if root]
        self.folders: list[Path] = []
        for root in filter(None, mesh_roots):
            self.folders += share_folders() if root == ALL_PACKAGES else [Path(root).absolute()]
        if scene_file:
            self.folders.append(Path(scene_file).absolute().parent)
        self._to_write = list(self.folders)
        self.folders += self.package_roots
        self._resolver = ResourceResolver(self.package_roots, self.folders)

    def file(self, uri: str, what: str) -> Path:
        """Return the path of a file that exists; raises ArgumentError for one not to be opened.

        ``what`` names the field that ``uri`` came in, for the error.
        """
        try:
            return self._resolver.resolve(uri, Path.cwd())
        except ValueError as error:
            raise ArgumentError(f'{what}: {error}. See the parameter mesh_roots.') from None

    def new_file(self, path: str, what: str) -> Path:
        """Return the path of a file to write, in a folder whose path is resolved.

        What it itself stands for is for who writes to look at. Raises ArgumentError outside the
        folders, there and where a link leads, and everywhere where nothing may be written.
        """
        if not self._writes:
            raise ArgumentError(
                f'{what}: {path!r} would be written, and the parameter allow_writes is false. An '
                'empty path asks for the text alone.'
            )
        target = Path(path).absolute()
        target = target.parent.resolve() / target.name
        roots = [root.resolve() for root in self._to_write]
        if not all(
            any(each.is_relative_to(root) for root in roots) for each in (target, target.resolve())
        ):
            folders = ', '.join(map(str, self._to_write)) or 'none'
            raise ArgumentError(
                f'{what}: {str(target)!r} lies outside the folders that files may be opened in: '
                f'{folders}. See the parameter mesh_roots.'
            )
        return target
