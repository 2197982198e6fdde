"""URDF and SRDF files from disk, with macros expanded if PyPI's ``xacro`` is installed.

Xacro opens any file that a text names and evaluates its expressions. Therefore only files that
the caller, or a scene file of the caller, names are expanded, and never texts that others send to
a node.
"""

from __future__ import annotations

import re
import sys
from importlib.util import find_spec
from pathlib import Path
from threading import Lock

from drake_geom_ros.scene_files.errors import SceneFileError, unreadable

_MACROS = re.compile(rb'<xacro:|\$[({]')
_ONE_AT_A_TIME = Lock()  # xacro keeps its state in module globals


def read_robot_file(path: Path, expand: bool) -> tuple[bytes, str]:
    """Return the content of a URDF or SRDF file, and its name for messages.

    With ``expand``, macros are expanded if there are any and xacro is installed. Lines then count
    in the expanded text, and the name says so. Raises SceneFileError for a file that cannot be
    read or that xacro refuses.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise unreadable(str(path), error) from error
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
            # Errors have many types, including those of the expressions in the file.
            reason = ' '.join(str(error).split()) or repr(error)
            raise SceneFileError(f'xacro cannot expand it: {reason}', str(path)) from None
        finally:
            sys.stdout = printed
    return text.encode()
