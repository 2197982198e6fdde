import pytest

from drake_geom_ros.common.stand_ins import stand_in


@pytest.mark.parametrize(
    ('data', 'word'),
    [
        (b'', 'empty'),
        (b'version https://git-lfs.github.com/spec/v1\noid sha256:ab\nsize 9\n', 'git lfs pull'),
        (b'\n<!DOCTYPE html><html>404</html>', 'web page'),
    ],
)
def test_what_is_no_file_of_its_own_is_named(data, word):
    assert word in stand_in(data)


@pytest.mark.parametrize('data', [b'solid a', b'\0', b'<robot name="r"/>', b'v 0 0 0'])
def test_other_files_are_none(data):
    assert stand_in(data) == ''
