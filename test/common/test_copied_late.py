"""An array that copies share: who writes never changes what another has, nor copies it in vain."""

import gc
import pickle

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.common.copied_late import CopiedLate

STEPS = st.lists(
    st.tuples(st.sampled_from(['copy', 'write', 'drop']), st.integers(0, 9), st.integers(0, 3)),
    max_size=40,
)


@given(STEPS)
def test_copies_are_as_if_each_were_made_at_once(steps):
    held, expected = [CopiedLate(np.zeros(4))], [np.zeros(4)]
    for number, (act, which, place) in enumerate(steps, 1):
        k = which % len(held)
        if act == 'copy':
            held.append(held[k].copy())
            expected.append(expected[k].copy())
        elif act == 'write':
            held[k].writable()[place] = number
            expected[k][place] = number
        elif len(held) > 1:
            del held[k], expected[k]
        for one, values in zip(held, expected, strict=True):
            np.testing.assert_array_equal(one.array, values)


def test_only_the_first_write_of_one_that_shares_copies():
    one = CopiedLate(np.zeros(4))
    array = one.array
    other = one.copy()
    assert other.array is array
    changed = other.writable()
    assert changed is not array
    assert other.writable() is changed
    assert one.writable() is array  # nobody has it beside this one any more


def test_nothing_is_copied_once_the_others_are_gone():
    one = CopiedLate(np.zeros(4))
    array = one.array
    other = one.copy()
    del other
    gc.collect()
    assert one.writable() is array


def test_one_that_was_sent_shares_nothing():
    one = CopiedLate(np.zeros(4))
    sent = pickle.loads(pickle.dumps(one))
    sent.writable()[0] = 1.0
    np.testing.assert_array_equal(one.array, np.zeros(4))
