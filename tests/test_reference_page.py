"""reference.md lists each public name with its arguments, its meaning and its page, as the code has them."""

from importlib import import_module

import pytest
from public_face import PUBLIC
from reference_page import about, signature, text, written

HINT = "python tests/support/reference_page.py updates the page"


def test_the_page_is_made_from_the_present_code() -> None:
    assert written() == text(), HINT


@pytest.mark.parametrize("package", PUBLIC)
def test_every_public_name_says_what_it_is(package: str) -> None:
    module = import_module(package)
    assert [name for name in module.__all__ if not about(name, module)] == []


def test_signatures_are_as_they_are_written() -> None:
    fieldrig = import_module("fieldrig")
    assert signature(fieldrig.Rig.run_for) == "(duration_ns: int)"
    assert signature(fieldrig.VirtualClock) == "(now_ns: int = 0)"
    assert signature(fieldrig.MS) == signature(fieldrig.Clock) == signature(fieldrig.RigError) == ""
    assert signature(import_module("fieldrig_bus.can").CanFrame).startswith(
        "(identifier: int, data: bytes = b'', is_ex"
    )
