"""Drives and their controller say the same, to the last bit, with each of their shortcuts and without."""

from collections.abc import Mapping

import pytest
from drive_line import GEARED, TWISTING, course
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.testing import plain_forms
from fieldrig_devices.max4.ring.drive_end import NEWS
from fieldrig_devices.mc4.axis import FOLD, REST
from fieldrig_devices.mc4.ring_side import FOLLOWING, REPEAT, STEADY
from fieldrig_devices.sercos.slave import UNDISTURBED

EACH = (FOLLOWING.name, REST.name, REPEAT.name, STEADY.name, NEWS.name, UNDISTURBED.name)
ALL = (FOLD.name, *EACH)
LOADS: tuple[Mapping[str, float], ...] = (GEARED, {}, TWISTING)


@pytest.mark.long
@pytest.mark.parametrize("names", [[name] for name in EACH] + [[FOLD.name, FOLLOWING.name]], ids=[*EACH, FOLD.name])
@pytest.mark.parametrize(("seed", "wires"), [(1, False), (2, True)])
def test_drives_say_the_same_without_one_shortcut(names: list[str], seed: int, wires: bool) -> None:
    found = course(seed, wires, LOADS)
    assert found.followed > 20
    with plain_forms(*names):
        plain = course(seed, wires, LOADS)
    assert (plain.followed == 0) is (FOLLOWING.name in names)
    assert found.said == plain.said
    if FOLD.name not in names:
        assert found.states() == plain.states()


@pytest.mark.long
@settings(max_examples=6, deadline=None)
@given(st.integers(3, 1 << 30), st.booleans())
def test_drives_say_the_same_without_any_shortcut(seed: int, wires: bool) -> None:
    found = course(seed, wires, LOADS)
    with plain_forms(*ALL):
        plain = course(seed, wires, LOADS)
    assert found.said == plain.said
