"""URDF and SRDF files from disk, macros expanded where PyPI's ``xacro`` is installed.

Xacro opens whatever files a text names and computes what it says: only files that the caller names
are expanded, or that a scene file of the caller's does, and never what others sent to a node.
"""

from __future__ import annotations

import re
import sys
from importlib.util import find_spec
from pathlib import Path
from threading import Lock

from drake_geom_ros.scene_files.errors import SceneFileError

_MACROS = re.compile(rb'<xacro:|\$[({]')
_ONE_AT_A_TIME = Lock()  # xacro keeps what it does in its module


def read_robot_file(path: Path, expand: bool) -> tuple[bytes, str]:
    """Return the content of a URDF or SRDF file, and what to call it in messages.

    With ``expand`` macros are expanded, if it has any and xacro is installed; lines are then those
    of the expanded text, which the name says. Raises SceneFileError for a file that cannot be
    read, and for what xacro refuses.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise SceneFileError(f'cannot be read: {error.strerror}', str(path)) from error
    if expand and _MACROS.search(data) and find_spec('xacro'):
        return _expanded(path), f'{path} (expanded)'
    return data, str(path)


def _expanded(path: Path) -> bytes:
    import xacro  # type: ignore[import-not-found, import-untyped, unused-ignore]

    with _ONE_AT_A_TIME:
        printed = sys.stdout
        try:
            text: str = xacro.process_file(str(path)).toprettyxml(indent='  ')
        except Exception as error:
            # Of many kinds, those of the expressions in the file among them.
            reason = ' '.join(str(error).split()) or repr(error)
            raise SceneFileError(f'xacro cannot expand it: {reason}', str(path)) from None
        finally:
            sys.stdout = printed
    return text.encode()
