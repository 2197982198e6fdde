"""Our types as definitions that lcm-gen reads, and the classes that it makes of them."""

import importlib
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from drake_geom_ros.geometry.visualizer._messages import DRAW, GEOMETRY_DATA, LINK_DATA, LOAD_ROBOT

TYPES = (GEOMETRY_DATA, LINK_DATA, LOAD_ROBOT, DRAW)
PACKAGE = 'drake_geom_viewer'


def definition(kind):
    """Return the text of a type's definition."""
    lines = [
        f'  {member.kind if isinstance(member.kind, str) else f"{PACKAGE}.{member.kind.name}"} '
        f'{member.name}{"".join(f"[{size}]" for size in member.sizes)};'
        for member in kind.members
    ]
    return '\n'.join([f'package {PACKAGE};', f'struct {kind.name} {{', *lines, '}', ''])


def generated(folder):
    """Return the module of classes that lcm-gen makes of our types, or skip."""
    pytest.importorskip('lcm', reason='its lcm-gen makes classes of our definitions')
    places = [sysconfig.get_path('scripts'), *(f'{path}/bin' for path in sys.path)]
    program = shutil.which('lcm-gen', path=os.pathsep.join(places))
    if program is None:
        pytest.skip('there is no lcm-gen')
    files = []
    for kind in TYPES:
        path = Path(folder) / f'{kind.name}.lcm'
        path.write_text(definition(kind))
        files.append(str(path))
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
    subprocess.run(
        [sys.executable, program, '--python', '--ppath', str(folder), *files]
        if Path(program).read_bytes().startswith(b'#!')
        else [program, '--python', '--ppath', str(folder), *files],
        check=True,
        env=environment,
    )
    sys.path.insert(0, str(folder))
    try:
        return importlib.import_module(PACKAGE)
    finally:
        sys.path.remove(str(folder))
