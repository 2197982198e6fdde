"""Full names are compared whole; what stands for two frames is refused with both."""

import pytest

from drake_geom_ros.common.frame_names import AmbiguousNameError, FrameNames, full_name

FRAMES = [('a', 'b::c'), ('a::b', 'c'), ('a::b', 'd'), ('a', 'x/y'), ('s', '#1'), ('s', '#1')]


def test_a_name_is_found_whole():
    names = FrameNames(FRAMES)
    for frame in FRAMES[2:]:
        assert names.find(full_name(frame)) == frame
        assert names.label(frame) == full_name(frame)
    assert names.find('b::c') is names.find('d') is names.find('') is None
    assert list(names) == ['a::b::c', 'a::b::d', 'a::x/y', 's::#1']


def test_what_stands_for_two_is_refused_with_both():
    names = FrameNames(FRAMES)
    with pytest.raises(AmbiguousNameError) as caught:
        names.find('a::b::c')
    assert str(caught.value) == (
        "'a::b::c' stands for 'b::c' of source 'a' and 'c' of source 'a::b'; rename one of them"
    )
    assert names.label(('a', 'b::c')) == "'b::c' of source 'a'"
