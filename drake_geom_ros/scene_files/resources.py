"""Resolution of file names in scenes and URDFs: ``package://``, ``file://`` and paths."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from urllib.parse import unquote, urlsplit

# What setup.py leaves in the environment that it is installed in.
_IN_INDEX = 'share/ament_index/resource_index/packages/drake_geom_ros'
_NAME = re.compile(rb'<name>([^<]*)</name>')
_MODELS = re.compile(rb'<sdf\s+version=["\']([0-9.]+)["\']\s*>([^<]*)</sdf>')
# Where Gazebo's users keep models.
_OF_MODELS = (
    'SDF_PATH',
    'GZ_SIM_RESOURCE_PATH',
    'IGN_GAZEBO_RESOURCE_PATH',
    'GAZEBO_MODEL_PATH',
    'GAZEBO_RESOURCE_PATH',
)
_MOST_OF_PACKAGE_XML = 65_536  # bytes that are searched for its name
# One folder, or several.
Roots = str | os.PathLike[str] | Iterable[str | os.PathLike[str]]


class ResourceResolver:
    """Finds files by URI.

    ``package://NAME/path`` is looked up in the first of these folders that exists
    (``package:///NAME/path`` means the same, as in urdfdom and Pinocchio):

    - ``ROOT/NAME``, or ROOT itself if that is its name or the name in its ``package.xml``, for
      each of ``package_roots`` and then of ``ROS_PACKAGE_PATH``;
    - the folders above the file that names it, if their ``package.xml`` has this name;
    - for ``model://NAME/path`` also the folders of ``SDF_PATH``, ``GZ_SIM_RESOURCE_PATH``,
      ``IGN_GAZEBO_RESOURCE_PATH``, ``GAZEBO_MODEL_PATH`` and ``GAZEBO_RESOURCE_PATH``, and at last
      a folder NAME beside or above the file;
    - ``PREFIX/share/NAME`` for each prefix of ``AMENT_PREFIX_PATH``, and for the environment that
      pip installed this package in;
    - ``cmeel.prefix/share/NAME`` beside the Python packages, where pip installs robot
      descriptions such as ``example-robot-data``.

    With ``allowed_roots`` a file outside these folders is refused; links inside are followed.
    """

    def __init__(
        self,
        package_roots: Roots = (),
        allowed_roots: Roots | None = None,
    ):
        """Set the folders, each argument one folder or several."""
        self._package_roots = [root.absolute() for root in _several(package_roots)]
        self._allowed_roots = None if allowed_roots is None else _folders(allowed_roots)

    @property
    def is_free(self) -> bool:
        """True if files anywhere may be opened."""
        return self._allowed_roots is None

    def looking_in(self, package_roots: Roots) -> ResourceResolver:
        """Return a resolver that searches these folders for packages after its own."""
        return ResourceResolver(
            [*self._package_roots, *_several(package_roots)], self._allowed_roots
        )

    def resolve(self, uri: str, folder: Path) -> Path:
        """Return the absolute path of the file of a URI; bare paths count from ``folder``.

        Raises ValueError for another scheme, an unknown package, a path that leaves its package,
        a file outside the allowed roots, and one that does not exist.
        """
        path = self._path(uri, folder)
        if not path.is_file():
            raise ValueError(f'{uri!r}: there is no file {path}')
        return path

    def model_file(self, uri: str, folder: Path) -> Path:
        """Return the file of a model of SDFormat, which may be named by its folder.

        A folder has a ``model.config`` that names the file of the latest version, or else a
        ``model.sdf``. Raises ValueError as ``resolve`` does.
        """
        path = self._path(uri, folder)
        if not path.is_dir():
            return self.resolve(uri, folder)
        return self.resolve(str(path / _latest_model(path)), folder)

    def _path(self, uri: str, folder: Path) -> Path:
        """Return the absolute path of a URI, which need not exist."""
        scheme, _, rest = uri.partition('://')
        if not rest:
            path = folder / uri
        elif scheme in ('package', 'model'):
            path = self._in_package(uri, rest, folder)
        elif scheme == 'file':
            path = Path(unquote(urlsplit(uri).path))
        else:
            raise ValueError(
                f'{uri!r}: scheme {scheme!r}; use package://, model://, file:// or a path'
            )
        path = Path(os.path.normpath(path.absolute()))
        self._check_allowed(uri, path)
        return path

    def _check_allowed(self, uri: str, path: Path) -> None:
        roots = self._allowed_roots
        if roots is not None and not any(path.is_relative_to(root) for root in roots):
            raise ValueError(
                f'{uri!r}: {path} lies outside the folders that files may be opened in: '
                f'{", ".join(map(str, roots)) or "none"}'
            )

    def _in_package(self, uri: str, rest: str, named_in: Path) -> Path:
        name, _, inner = rest.lstrip('/').partition('/')
        inner = inner.lstrip('/')
        if not name or name in ('.', '..') or os.path.normpath(inner).split(os.sep)[0] == '..':
            raise ValueError(f'{uri!r} must stay inside its package')
        is_model = uri.startswith('model://')
        folders = list(self._candidates(name, named_in, is_model))
        for folder in folders:
            if folder.is_dir():
                return folder / inner
        searched = ', '.join(map(str, folders)) or 'no folder'
        raise ValueError(
            f'{uri!r}: there is no package {name!r}; searched {searched}; '
            'source its workspace, install it with pip, or name its folder: package_roots in '
            'Python, in a scene file and of a node, --package-root of a command, ROS_PACKAGE_PATH'
        )

    def _candidates(self, name: str, named_in: Path, is_model: bool) -> Iterator[Path]:
        of_models = [folder for key in _OF_MODELS for folder in _in_variable(key)]
        for root in (*self._package_roots, *(of_models if is_model else ()), *_ros_package_path()):
            yield root if name in (root.name, _package_name(root)) else root / name
        here = named_in.absolute()
        yield from (up for up in (here, *here.parents) if _package_name(up) == name)
        for folder in _shares_of_prefixes():
            yield folder / name
        if is_model:
            yield from (up / name for up in here.parents)


def _package_name(folder: Path) -> str:
    """Return the name in a folder's ``package.xml``, '' if there is none."""
    try:
        with (folder / 'package.xml').open('rb') as file:
            named = _NAME.search(file.read(_MOST_OF_PACKAGE_XML))
    except OSError:
        return ''
    return named[1].decode(errors='replace').strip() if named else ''


def share_folders() -> list[Path]:
    """Return the folders that may hold packages' files, existing or not."""
    return [*_ros_package_path(), *_shares_of_prefixes()]


def _ros_package_path() -> list[Path]:
    return _in_variable('ROS_PACKAGE_PATH')


def _in_variable(name: str) -> list[Path]:
    return _paths(os.environ.get(name, '').split(os.pathsep))


def _latest_model(folder: Path) -> str:
    """Return the file that a folder's ``model.config`` names for the latest version."""
    try:
        named = _MODELS.findall((folder / 'model.config').read_bytes())
    except OSError:
        named = []
    files = {tuple(map(int, version.split(b'.'))): file for version, file in named}
    return files[max(files)].decode(errors='replace').strip() if files else 'model.sdf'


def _shares_of_prefixes() -> list[Path]:
    prefixes = _paths(os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep))
    environment = Path(sys.prefix)
    if (environment / _IN_INDEX).is_file() and environment not in prefixes:
        prefixes.append(environment)
    installed = [e for e in _paths(sys.path) if e.name in ('site-packages', 'dist-packages')]
    prefixes += [entry / 'cmeel.prefix' for entry in installed]
    return [prefix / 'share' for prefix in prefixes]


def _several(roots: Roots) -> list[Path]:
    """Return folders as a list, from one path or several."""
    return [Path(roots)] if isinstance(roots, (str, os.PathLike)) else [*map(Path, roots)]


def _folders(roots: Roots) -> list[Path]:
    return [Path(os.path.normpath(root.absolute())) for root in _several(roots)]


def _paths(entries: Sequence[str]) -> list[Path]:
    return [Path(entry) for entry in entries if entry]
