"""Errors of the card as emergency messages (digest chapter 20): code, register, the card's code, its axis and state."""

import pytest
from arp_face import FaceBench

from fieldrig_bus.can.notices import BusState, CanState
from fieldrig_devices.arp.can.emergencies import MEANINGS
from fieldrig_devices.arp.card_errors import BLOCKING


@pytest.fixture
def bench() -> FaceBench:
    bench = FaceBench()
    bench.start()
    return bench


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (103, "30 55 01 67 00 00 03 00"),
        (105, "00 90 01 69 00 00 03 00"),
        (106, "30 81 11 6a 00 00 03 00"),
        (111, "00 62 81 6f 00 00 03 00"),
        (112, "00 61 81 70 00 00 03 00"),
        (113, "20 63 81 71 00 00 03 00"),
        (116, "11 86 81 74 00 00 03 00"),
    ],
)
def test_each_error_has_its_message_and_its_end(bench: FaceBench, error: int, message: str) -> None:
    bench.card.errors.fail(error)
    assert bench.refresh() == [f"08A#{message}"]
    assert bench.refresh() == []
    bench.card.errors.clear()
    assert bench.refresh() == ["08A#00 00 00 00 00 00 00 00"]


def test_every_error_of_the_card_is_sent() -> None:
    assert set(MEANINGS) == {103, 105, 106, 111, 112, 113, 116} >= BLOCKING


def test_axis_of_a_control_loss(bench: FaceBench) -> None:
    bench.card.errors.fail(116, 2)
    assert bench.refresh() == ["08A#11 86 81 74 00 02 03 00"]


def test_errors_add_up_and_are_cleared_together(bench: FaceBench) -> None:
    bench.card.errors.fail(106)
    bench.refresh()
    bench.card.errors.fail(116, 1)
    assert bench.refresh() == ["08A#11 86 91 74 00 01 03 00"]
    assert bench.sdo("40 01 10 00 00 00 00 00") == "4f 01 10 00 91 00 00 00"
    assert bench.sdo("40 03 10 01 00 00 00 00") == "43 03 10 01 11 86 74 00"
    assert bench.sdo("40 03 10 02 00 00 00 00") == "43 03 10 02 30 81 6a 00"
    bench.card.errors.clear()
    assert bench.refresh() == ["08A#00 00 81 00 00 00 00 00", "08A#00 00 00 00 00 00 00 00"]


@pytest.mark.long
def test_warnings_are_not_sent(bench: FaceBench) -> None:
    bench.card.errors.warn(203)
    assert bench.refresh() == []


def test_an_error_at_power_on_follows_the_boot_up_message() -> None:
    bench = FaceBench()
    bench.card.errors.fail(105)
    assert bench.start() == ["70A#00", "08A#00 90 01 69 00 00 03 00"]


def test_after_a_reset_of_the_node_errors_are_sent_again(bench: FaceBench) -> None:
    bench.card.errors.fail(116, 1)
    bench.refresh()
    assert bench.send("000#81 0A") == ["70A#00"]
    assert bench.refresh() == ["08A#11 86 81 74 00 01 03 00"]


def test_bus_off_is_sent_after_its_recovery(bench: FaceBench) -> None:
    """8140h.  The monitor of the modules makes it an error of the card, which stays until it is cleared."""
    bench.notice(BusState(CanState.BUS_OFF, 256, 0))
    bench.card.errors.fail(106)
    bench.notice(BusState(CanState.ACTIVE, 0, 0))
    bench.after(0)
    assert bench.refresh() == ["08A#40 81 11 6a 00 00 03 00"]
    bench.card.errors.clear()
    assert bench.refresh() == ["08A#00 00 00 00 00 00 00 00"]
