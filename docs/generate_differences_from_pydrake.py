"""Writes differences_from_pydrake.md: python docs/generate_differences_from_pydrake.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

DOCS = Path(__file__).resolve().parent
TABLE = DOCS / 'differences.yaml'
TARGET = DOCS / 'differences_from_pydrake.md'
_INTRODUCTION = """# Differences from pydrake

Made from [differences.yaml](differences.yaml) by
`python docs/generate_differences_from_pydrake.py`. A test runs each example with this package, and
with pydrake 1.51 where that is installed, and knows of every public name of pydrake whether it is
here or in the list of what is missing. All other methods take the arguments that pydrake's take,
by the same keywords.

To port a script, import `drake_geom_ros.geometry`, `drake_geom_ros.math` and
`drake_geom_ros.common` in place of `pydrake.geometry`, `pydrake.math` and `pydrake.common`. Older
names are there too, where the meaning is one: `SurfaceMesh` beside `TriangleSurfaceMesh`, `X_WF`
beside `GetPoseInWorld`, `ExcludeCollisionsWithin`, `absolute_filename`.

## On purpose

In the examples `g` is the module `geometry`, `m` is `math`, `np` is NumPy, and

```python
{prelude}```
"""
_IN_WORDS = """
More that no example shows:

- Mesh files are read in the formats of trimesh (OBJ, STL, PLY, glTF and more), which pydrake does
  not all read, but not as `.vtk`. Other files that one names are not opened: buffers of glTF must
  be embedded, and `supporting_files` of an `InMemoryMesh` are kept, not read.
- Numbers that pydrake ends the process for, such as `Capsule(1, 0)`, raise a RuntimeError.
- Every answer has an `error_bound`, every query takes `accuracy`; the page
  [concepts](concepts.md) says more of what is ours.
- A file that was pickled with pydrake makes objects of pydrake.
- Errors have texts of their own, which say what was asked and what is allowed.
- There is one scalar type, float: `SceneGraph_[float]`.
- There is no systems framework: a SceneGraph is no LeafSystem, and its ports have `FixValue` and
  `Eval` alone; nor is there `pydrake.geometry.optimization`, or what served pictures in 2020
  (`pydrake.geometry.render`, `ConnectDrakeVisualizer`, `get_pose_bundle_output_port`).
- The property `('mesh', 'solid')` makes a Mesh a body that need not be convex.
"""


def differences() -> str:
    """Return the text of the page."""
    table = yaml.safe_load(TABLE.read_text())
    parts = [_INTRODUCTION.replace('{prelude}', table['prelude'])]
    parts += [_example(entry) for entry in table['on_purpose']]
    parts += [_IN_WORDS, '## Missing\n']
    for entry in table['missing']:
        names = [
            f'`{name}`'
            for module, text in entry.items()
            if module != 'why'
            for name in text.split()
        ]
        parts.append(f'{entry["why"]}: {", ".join(names)}.\n')
    return '\n'.join(parts)


def _example(entry: dict[str, Any]) -> str:
    """Return the section of one difference."""
    return (
        f'### {entry["title"]}\n\n{entry["why"]}\n\n```python\n{entry["code"].rstrip()}\n```\n\n'
        f'Here `{entry["ours"]}`, in pydrake `{entry["pydrake"]}`.\n'
    )


if __name__ == '__main__':
    TARGET.write_text(differences())
