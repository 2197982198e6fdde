"""VTK surfaces of shapes, made of triangles in the geometry's frame [m]."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkFiltersGeneral import vtkTransformFilter
from vtkmodules.vtkFiltersSources import (
    vtkCubeSource,
    vtkCylinderSource,
    vtkPlaneSource,
    vtkTexturedSphereSource,
)

from drake_geom_ros.geometry.shapes.primitives import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Shape,
    Sphere,
)

# Corners around an axis: a polygon with this number deviates by 1.2e-3 of a radius.
AROUND = 64
_PLATE = 100.0  # [m] the side of the plate that represents a half space


def surface_of_shape(shape: Shape) -> Any:
    """Return the vtkPolyData of a primitive, None for a mesh."""
    if isinstance(shape, Sphere):
        return _ball(*[shape.radius()] * 3)
    if isinstance(shape, Ellipsoid):
        return _ball(shape.a(), shape.b(), shape.c())
    if isinstance(shape, Box):
        box = vtkCubeSource()
        box.SetXLength(shape.width())
        box.SetYLength(shape.depth())
        box.SetZLength(shape.height())
        box.Update()
        return box.GetOutput()
    if isinstance(shape, (Cylinder, Capsule)):
        return _along_z(shape.radius(), shape.length(), capped=isinstance(shape, Capsule))
    if isinstance(shape, HalfSpace):
        plate = vtkPlaneSource()
        half = _PLATE / 2.0
        plate.SetOrigin(-half, -half, 0.0)
        plate.SetPoint1(half, -half, 0.0)
        plate.SetPoint2(-half, half, 0.0)
        plate.Update()
        return plate.GetOutput()
    return None


def _ball(a: float, b: float, c: float) -> Any:
    """Return an ellipsoid with these semi-axes [m], with texture coordinates."""
    ball = vtkTexturedSphereSource()
    ball.SetRadius(1.0)
    ball.SetThetaResolution(AROUND)
    ball.SetPhiResolution(AROUND // 2)
    stretched = vtkTransform()
    stretched.Scale(a, b, c)
    return _transformed(ball, stretched)


def _along_z(radius: float, length: float, *, capped: bool) -> Any:
    """Return a cylinder about z, or a capsule."""
    source = vtkCylinderSource()
    source.SetResolution(AROUND)
    source.SetRadius(radius)
    source.SetHeight(length)
    source.SetCapsuleCap(capped)
    source.SetLatLongTessellation(True)
    upright = vtkTransform()
    upright.RotateX(90.0)  # the axis of VTK's cylinders is y
    return _transformed(source, upright)


def _transformed(source: Any, transform: Any) -> Any:
    """Return the surface of a source, transformed, with its normals."""
    moving = vtkTransformFilter()
    moving.SetInputConnection(source.GetOutputPort())
    moving.SetTransform(transform)
    moving.Update()
    return moving.GetOutput()


def surface_of_triangles(vertices: NDArray[np.float64], triangles: NDArray[Any]) -> Any:
    """Return the vtkPolyData of vertices (n, 3) [m] and triangles (m, 3)."""
    points = vtkPoints()
    points.SetData(numpy_to_vtk(vertices, deep=True))
    cells = vtkCellArray()
    starts = numpy_to_vtkIdTypeArray(3 * np.arange(len(triangles) + 1), deep=True)
    corners = numpy_to_vtkIdTypeArray(triangles.astype(np.int64).ravel(), deep=True)
    cells.SetData(starts, corners)
    made = vtkPolyData()
    made.SetPoints(points)
    made.SetPolys(cells)
    return made


def painted(surface: Any, colours: NDArray[np.float32]) -> Any:
    """Return a surface whose triangles have colours (m, 3) from 0 to 1."""
    made = vtkPolyData()
    made.ShallowCopy(surface)
    of_bytes = np.round(255.0 * colours).astype(np.uint8)
    made.GetCellData().SetScalars(numpy_to_vtk(of_bytes, deep=True))
    return made
