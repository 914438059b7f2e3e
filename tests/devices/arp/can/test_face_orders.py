"""Run, stop, reset and save, by SDO command, by control byte, and by 1010h."""

import pytest
from arp_face import FaceBench

DEVICE_STATE = "22 00 00 08"


@pytest.fixture
def bench() -> FaceBench:
    bench = FaceBench()
    bench.start()
    bench.send("000#01 0A")
    return bench


@pytest.mark.parametrize(("command", "asked"), [("01", "run"), ("02", "stop"), ("03", "reset")])
def test_a_command_acts_each_time_it_is_written(bench: FaceBench, command: str, asked: str) -> None:
    for _ in range(2):
        assert bench.sdo(f"2F 00 21 00 {command} 00 00 00") == "60 00 21 00 00 00 00 00"
    assert bench.card.asked == [asked, asked]


@pytest.mark.long
@pytest.mark.parametrize("command", ["01", "02"])
def test_a_command_that_the_state_forbids_is_refused(bench: FaceBench, command: str) -> None:
    bench.card.is_willing = False
    assert bench.sdo(f"2F 00 21 00 {command} 00 00 00") == f"80 00 21 00 {DEVICE_STATE}"


@pytest.mark.long
def test_there_are_four_commands_that_are_write_only(bench: FaceBench) -> None:
    assert bench.sdo("2F 00 21 00 00 00 00 00") == "80 00 21 00 32 00 09 06"
    assert bench.sdo("2F 00 21 00 05 00 00 00") == "80 00 21 00 31 00 09 06"
    assert bench.sdo("40 00 21 00 00 00 00 00") == "80 00 21 00 01 00 01 06"


def test_bits_of_the_control_byte_act_when_they_rise(bench: FaceBench) -> None:
    """Send RPDO 1: the control byte, 3 unused bytes, and F33 to F64."""
    for control in ("01", "01", "00", "01", "03", "07"):
        bench.send(f"20A#{control} 00 00 00 00 00 00 00")
    assert bench.card.asked == ["run", "run", "stop", "reset"]


def test_stop_and_run_together_start_again(bench: FaceBench) -> None:
    bench.send("20A#03 00 00 00 00 00 00 00")
    assert bench.card.asked == ["stop", "run"]


def test_what_the_control_byte_was_refused_does_not_start_later(bench: FaceBench) -> None:
    bench.card.is_willing = False
    bench.send("20A#01 00 00 00 00 00 00 00")
    bench.card.is_willing = True
    bench.send("20A#01 00 00 00 00 00 00 00")
    assert bench.card.asked == ["run"]


def test_control_byte_by_sdo_says_that_it_was_refused(bench: FaceBench) -> None:
    bench.card.is_willing = False
    assert bench.sdo("2F 01 21 00 02 00 00 00") == f"80 01 21 00 {DEVICE_STATE}"


@pytest.mark.parametrize("request_", ["2F 00 21 00 04 00 00 00", "23 10 10 01 73 61 76 65", "23 10 10 04 73 61 76 65"])
def test_parameters_in_ram_are_saved_to_flash(bench: FaceBench, request_: str) -> None:
    """Command 4, and 'save' to 1010h.  Only changed values are written."""
    bench.sdo("23 01 23 0B C4 09 00 00")  # @Par1[11] = 2.500
    assert bench.sdo(request_)[:2] == "60"
    assert bench.card.asked == ["save 1/11"]
    assert bench.card.parameters.flash[1][11] == 2500


@pytest.mark.long
def test_communication_parameters_alone_leave_flash_as_it_is(bench: FaceBench) -> None:
    bench.sdo("23 01 23 0B C4 09 00 00")
    assert bench.sdo("23 10 10 02 73 61 76 65")[:2] == "60"
    assert bench.card.asked == []


@pytest.mark.long
def test_a_wrong_signature_saves_nothing(bench: FaceBench) -> None:
    bench.sdo("23 01 23 0B C4 09 00 00")
    assert bench.sdo("23 10 10 01 53 41 56 45") == "80 10 10 01 20 00 00 08"
    assert bench.card.asked == []


def test_restored_defaults_are_in_flash_and_wait_for_the_next_start(bench: FaceBench) -> None:
    bench.sdo("23 01 23 0B C4 09 00 00")
    bench.sdo("23 10 10 04 73 61 76 65")
    assert bench.sdo("23 11 10 04 6C 6F 61 64") == "60 11 10 04 00 00 00 00"
    assert bench.card.parameters.flash[1][11] == 1000
    assert bench.card.parameters.ram[1][11] == 2500


def test_node_keeps_its_pdo_parameters_and_no_variables(bench: FaceBench) -> None:
    """1010h saves TPDO 1 with SYNC.  V1 is not part of it, because the card has its own memory."""
    bench.sdo("2F 00 18 02 01 00 00 00")
    bench.sdo("23 00 20 01 88 13 00 00")
    bench.sdo("23 10 10 01 73 61 76 65")
    again = FaceBench(bench.store)
    again.start()
    assert again.sdo("40 00 18 02 00 00 00 00") == "4f 00 18 02 01 00 00 00"
    assert again.card.V[1] == 0
    kept = bench.store.load()
    assert kept is not None
    assert b"2000" not in kept
