import pytest

from drake_geom_ros.scene_files.errors import Location, SceneFileError


@pytest.mark.parametrize(
    ('place', 'text'),
    [
        (
            Location('arms.yaml', 12, 'geometries[3].shape.radius'),
            'arms.yaml:12: geometries[3].shape.radius: -1.0 must be > 0',
        ),
        (Location('arms.yaml', 12), 'arms.yaml:12: -1.0 must be > 0'),
        (Location('arms.yaml'), 'arms.yaml: -1.0 must be > 0'),
    ],
)
def test_an_error_names_file_line_and_key(place, text):
    error = place.error('-1.0 must be > 0')
    assert str(error) == text
    assert (error.file, error.line, error.key) == (place.file, place.line, place.key)
    assert error.reason == '-1.0 must be > 0'


def test_it_is_the_runtime_error_that_pydrake_users_expect():
    assert issubclass(SceneFileError, RuntimeError)
