"""Writes differences_from_pydrake.md: python docs/generate_differences_from_pydrake.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

DOCS = Path(__file__).resolve().parent
TABLE = DOCS / 'differences.yaml'
TARGET = DOCS / 'differences_from_pydrake.md'
PORT = DOCS.parent / 'examples/port_of_a_diagram.py'
_INTRODUCTION = """# Differences from pydrake

Generated from [differences.yaml](differences.yaml) by
`python docs/generate_differences_from_pydrake.py`; a test runs each example with this package, and
with pydrake where that is installed. All names are those of pydrake 1.58; 1.51, the last version
with wheels for Python 3.10 and 3.11, gives the same answers.

A script that uses `SceneGraph` without a Diagram runs after its imports are changed: write
`drake_geom_ros.geometry`, `drake_geom_ros.math` and `drake_geom_ros.common` in place of
`pydrake.geometry`, `pydrake.math` and `pydrake.common`. Methods take the arguments that pydrake's
take, by the same keywords. Older names exist too, where the meaning is the same: `SurfaceMesh`
beside `TriangleSurfaceMesh`, `X_WF` beside `GetPoseInWorld`, `ExcludeCollisionsWithin`,
`absolute_filename`. A script with a Diagram, a MultibodyPlant or a Parser has to be ported.

## Porting a script with a Diagram

There is no systems framework here, and no dynamics. A Diagram is replaced by calls in a row: load
the scene, compute the poses of the links, set them, query.

| pydrake | here |
|---|---|
{calls}

This is a complete port. It loads a robot, sets its joints and prints the smallest distance:

```python
{port}```

## Differences on purpose

In the examples `g` is the module `geometry`, `m` is `math`, `np` is NumPy, and

```python
{prelude}```
"""
_IN_WORDS = """
### Other differences

- Mesh files are OBJ, glTF, VTK (in ASCII), and what pydrake does not read: GLB, STL, PLY, OFF, 3MF
  and DAE (Collada), the last two in metres by their units. glTF is turned to z up and scaled after
  that, as in pydrake; one with a skin or with morph targets that are on is refused, where pydrake
  takes the mesh as it is before it is bent. Buffers of glTF may be files in its folder or below,
  or files in memory among the `supporting_files` of an `InMemoryMesh`.
- Vertices of a `.vtk` file that no tetrahedron has are left out; pydrake counts their distance to
  the boundary in the pressure. Of a compliant one, tetrahedra with all corners on the boundary are
  cut by `RefineVolumeMesh` first, and one in several pieces is refused: in pydrake such parts
  overlap a body without a surface.
- Numbers for which pydrake ends the process, such as `Capsule(1, 0)`, raise a RuntimeError.
- Every answer has an `error_bound`, and every query takes `accuracy`: see [concepts](concepts.md).
- A file that was pickled with pydrake contains objects of pydrake.
- Error texts differ; they say what was asked and what is allowed.
- The scalar types are float and AutoDiffXd: there is no `SceneGraph_[Expression]`. AutoDiffXd is
  answered for all pairs of shapes, and where a point or normal has no derivative asking for it
  raises: see [derivatives](derivatives.md).
- There is no systems framework: a SceneGraph is not a LeafSystem, and its ports have only
  `FixValue` and `Eval`. Also missing are `pydrake.geometry.optimization` and what served pictures
  in 2020, `pydrake.geometry.render`. `ConnectDrakeVisualizer` of 2020 takes None as its builder,
  and what it returns sends when `Publish(context, time)` is called: see [viewing](viewing.md).
- The property `('mesh', 'solid')` makes a Mesh a body that need not be convex.
- [Contact surfaces](contact_surfaces.md): each polygon has its own vertices, where pydrake shares
  those in a half space. A compliant half space and a compliant body have a surface. Touching is no
  contact; a `margin` is refused. There are none of poses that are AutoDiffXd.
- `ComputeContactSurfaces` raises for a pair that can have no surface only where it overlaps, and
  for one of which a body is so deep within the other that it has none, where pydrake's answer is
  empty. `ComputeContactSurfacesWithFallback` gives both as points. It raises for two half spaces,
  as pydrake does wherever they are.
- A closed piece of a rigid Mesh that is inside out is turned, and one with neighbours turned
  opposite ways is refused.
"""


def differences() -> str:
    """Return the text of the page."""
    table = yaml.safe_load(TABLE.read_text())
    calls = '\n'.join(f'| {old} | {new} |' for old, new in table['port'].items())
    introduction = _INTRODUCTION.replace('{port}', PORT.read_text()).replace('{calls}', calls)
    parts = [introduction.replace('{prelude}', table['prelude'])]
    parts += [_example(entry) for entry in table['on_purpose']]
    parts += [
        _IN_WORDS,
        '## Missing\n\nImporting one of these raises an ImportError that names this page.\n',
    ]
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
