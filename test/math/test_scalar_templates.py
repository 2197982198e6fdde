"""Templates are asked for by the types that pydrake's are."""

import pytest

from drake_geom_ros.autodiffutils import AutoDiffXd
from drake_geom_ros.geometry import (
    ContactSurface,
    ContactSurface_,
    PolygonSurfaceMeshFieldLinear,
    PolygonSurfaceMeshFieldLinear_,
    TriangleSurfaceMeshFieldLinear,
    TriangleSurfaceMeshFieldLinear_,
)
from drake_geom_ros.math import RigidTransform, RigidTransform_

FIELDS = {
    PolygonSurfaceMeshFieldLinear_: PolygonSurfaceMeshFieldLinear,
    TriangleSurfaceMeshFieldLinear_: TriangleSurfaceMeshFieldLinear,
}


def test_of_one_type():
    for template, instantiation in (
        (ContactSurface_, ContactSurface),
        (RigidTransform_, RigidTransform),
    ):
        assert template[float] is template[(float,)] is instantiation


def test_a_field_has_one_for_its_values_and_one_for_its_mesh():
    for template, instantiation in FIELDS.items():
        assert template[float, float] is instantiation


@pytest.mark.parametrize(
    ('template', 'given'),
    [
        (ContactSurface_, AutoDiffXd),
        (ContactSurface_, (float, float)),
        (ContactSurface_, ()),
        (ContactSurface_, int),
        (PolygonSurfaceMeshFieldLinear_, float),
        (PolygonSurfaceMeshFieldLinear_, (float, AutoDiffXd)),
        (TriangleSurfaceMeshFieldLinear_, 3 * (float,)),
    ],
)
def test_what_there_is_not_is_refused_with_what_there_is(template, given):
    there = 'float, float' if template in FIELDS else 'float'
    with pytest.raises(RuntimeError, match=rf'there is {template!r}\[{there}\] only'):
        template[given]
