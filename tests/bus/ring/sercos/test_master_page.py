"""A member that only sends like the master of a ring is named; ring.md shows a test that is the master."""

import logging

import pytest

from fieldrig_bus.ring.sercos.message import Mst
from fieldrig_bus.ring.sercos.virtual import RingModel


def test_a_member_that_sends_as_the_master_without_being_it_is_named_once(caplog: pytest.LogCaptureFixture) -> None:
    model = RingModel([], 4)
    model.join("test")
    model.listen(0, "test", None)
    with caplog.at_level(logging.WARNING):
        for number in range(3):
            model.submit(number, "test", Mst(number, b"\xff\x00"))
    (message,) = caplog.messages
    assert "test is not the master of the ring" in message
    assert '["master"]' in message
    assert model.next_ns() is None
