"""Files of numbers on a grid for volume viewers: NRRD and OpenVDB."""

from __future__ import annotations

import contextlib
import io
import os
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, Any

import numpy as np

from drake_geom_ros.common.extras import needed_for
from drake_geom_ros.math.array_types import Floats

_OPENVDB = (
    "PyPI has no wheels of it; install OpenVDB's Python module by apt-get install python3-openvdb "
    "for the system's Python, or by conda install -c conda-forge openvdb"
)


def write_nrrd(file: IO[bytes], values: Floats, origin: Floats, resolution: float) -> None:
    """Write values (nx, ny, nz) with origin (3,) [m] and spacing [m] as NRRD.

    Raises ImportError without the extra ``nrrd``.
    """
    with needed_for('.nrrd files', 'nrrd'):
        import nrrd

    header = {
        'space': 'right-anterior-superior',
        'space directions': resolution * np.eye(3),
        'space origin': origin,
        'space units': ['m', 'm', 'm'],
    }
    nrrd.write(file, values, header)


def write_vdb(
    file: IO[bytes], distances: Floats, error_bound: float, origin: Floats, resolution: float
) -> None:
    """Write signed distances (nx, ny, nz) [m] as a level set of OpenVDB, called ``distance``.

    OpenVDB keeps single precision. The grid's metadata ``error_bound`` [m] covers that rounding
    beside the given bound. Every voxel is active; the background is above the largest magnitude.

    Raises ImportError without OpenVDB's Python module, or with one for another NumPy.
    """
    vdb = _openvdb()
    single = distances.astype(np.float32)
    # A voxel that equals the background would be inactive.
    grid = vdb.FloatGrid(float(np.nextafter(np.abs(single).max(), np.float32(np.inf))))
    grid.copyFromArray(single)
    grid.name = 'distance'
    grid.gridClass = vdb.GridClass.LEVEL_SET
    grid.transform = vdb.createLinearTransform(voxelSize=float(resolution))
    grid.transform.translate(tuple(origin.tolist()))
    rounding = float(np.abs(single - distances).max())
    bound = np.nextafter(np.float32(error_bound + rounding), np.float32(np.inf))
    grid['error_bound'] = float(bound)
    with TemporaryDirectory() as folder:  # OpenVDB writes to names only
        path = Path(folder) / 'field.vdb'
        vdb.write(os.fspath(path), grids=[grid])
        file.write(path.read_bytes())


def _openvdb() -> Any:
    """Return OpenVDB's Python module, by its name of today or of before; raises ImportError.

    Up to version 10 it is made with Boost.Python for NumPy 1. Beside NumPy 2 it imports, with a
    message of NumPy's on stderr, and ends the process when it is used.
    """
    with needed_for('.vdb files', _OPENVDB), contextlib.redirect_stderr(io.StringIO()):
        try:
            import openvdb as vdb
        except ModuleNotFoundError:
            import pyopenvdb as vdb
    if (
        type(vdb.FloatGrid).__module__.startswith('Boost')
        and int(np.__version__.split('.')[0]) > 1
    ):
        raise ImportError(
            f'.vdb files cannot be written by {vdb.__name__} here ({vdb.__file__}): it was made '
            f'for NumPy 1, and this is NumPy {np.__version__}; save them in an environment with '
            'NumPy 1, or install a newer OpenVDB',
            name=vdb.__name__,
        )
    return vdb
