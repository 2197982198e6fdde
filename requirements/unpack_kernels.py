"""Unpacks the kernels of a wheel into a cache folder: WHEEL FOLDER. Those of other sources too.

They are found by a name for the content of all sources; what bears another one is never loaded,
and removed in time.
"""

import sys
import zipfile
from pathlib import Path, PurePosixPath

wheel, cache = sys.argv[1:]
folder = Path(cache) / 'drake_geom_ros'
folder.mkdir(mode=0o700, parents=True, exist_ok=True)
count = 0
with zipfile.ZipFile(wheel) as archive:
    for name in archive.namelist():
        path = PurePosixPath(name)
        if path.parts[:2] == ('drake_geom_ros', '_kernels') and '..' not in path.parts:
            target = folder.joinpath(*path.parts[2:])
            target.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not target.exists():
                target.write_bytes(archive.read(name))
                count += 1
print(f'{count} kernels from {wheel}')
