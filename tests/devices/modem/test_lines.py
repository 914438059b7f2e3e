"""Control lines and flow control of a modem at its terminal (TIA-232; PD-246, PD-248)."""

from typing import Any

import pytest
from modem_bench import ModemBench

from fieldrig_bus.serial.message import ControlLines, Format
from fieldrig_bus.telephone.message import Carrier, Heard, Hook, Ready, Ring, Tone


def test_a_modem_that_is_on_is_ready_without_a_carrier() -> None:
    inputs = ModemBench().inputs
    assert inputs._asdict() == {"cts": True, "dsr": True, "dcd": False, "ri": False}


@pytest.mark.manual("PD-246", "PD-248")
def test_dcd_follows_the_carrier_with_c1_and_is_always_on_with_c0() -> None:
    bench = ModemBench()
    assert bench.connected().inputs.dcd is True
    assert bench.hear(Carrier(0)).wait(2).inputs.dcd is False
    bench.ask("AT&C0")
    assert bench.inputs.dcd


@pytest.mark.manual("PD-248")
def test_dsr_is_always_on_with_s0_and_follows_calls_with_s1() -> None:
    bench = ModemBench()
    bench.ask("AT&S1")
    assert not bench.inputs.dsr
    assert bench.connected().inputs.dsr
    assert not bench.hear(Heard(Tone.BUSY)).inputs.dsr
    bench.ask("AT&S0")
    assert bench.inputs.dsr


D_ROWS: list[tuple[int, dict[str, Any]]] = [
    (0, {"mode": "online", "call": "connected"}),
    (1, {"mode": "online command", "call": "connected"}),
    (2, {"mode": "command", "call": "idle"}),
    (3, {"mode": "command", "call": "idle"}),
]


@pytest.mark.parametrize(("d", "expected"), D_ROWS)
def test_d_decides_what_dtr_off_does(d: int, expected: dict[str, Any]) -> None:
    bench = ModemBench().connected(command=f"AT&D{d}S7=77DT200").set(dtr=False).wait(0.04)
    assert bench.point("mode") == "online"  # S25 is 50 ms
    bench.wait(0.02)
    assert {key: bench.point(key) for key in expected} == expected
    bench.set(dtr=True).heard()
    if d >= 2:
        assert bench.lines_of("ATS7?") == ["050" if d == 3 else "077", "OK"]


def test_a_short_pulse_of_dtr_is_ignored() -> None:
    bench = ModemBench().connected().set(dtr=False).wait(0.04).set(dtr=True).wait(1)
    assert bench.point("call") == "connected"


@pytest.mark.parametrize(("d", "is_answered"), [(0, True), (1, True), (2, False), (3, False)])
def test_without_dtr_a_modem_answers_by_itself_only_if_dtr_is_ignored(d: int, is_answered: bool) -> None:
    bench = ModemBench()
    bench.ask(f"AT&D{d}S0=1")
    bench.said()
    bench.set(dtr=False).wait(1).hear(Ring(True), Ring(False))
    assert (bench.said() == [Hook(True)]) is is_answered


# ---- flow control

MUCH = bytes(range(256)) * 8


@pytest.mark.parametrize(("command", "cts"), [
    ("AT&K3&R0DT200", False), ("AT&K3&R1DT200", True), ("AT&K0DT200", True), ("AT&K4DT200", True)])  # fmt: skip
@pytest.mark.manual("PD-246", "PD-248")
def test_cts_goes_off_while_much_waits_for_the_line(command: str, cts: bool) -> None:
    bench = ModemBench().connected(command=command)
    bench.heard()
    bench.type(MUCH)
    assert bench.point("cts") is cts
    bench.wait(3)
    assert bench.point("cts")
    sent = b"".join(message for message in bench.said() if isinstance(message, bytes))
    assert sent == MUCH.replace(b"\x11", b"").replace(b"\x13", b"") if "K4" in command else sent == MUCH


@pytest.mark.parametrize(
    ("command", "is_held"), [("AT&K3DT200", True), ("AT&K3&R1DT200", False), ("AT&K0DT200", False)]
)
@pytest.mark.manual("PD-246", "PD-248")
def test_rts_off_holds_the_data_for_the_terminal(command: str, is_held: bool) -> None:
    bench = ModemBench().connected(command=command)
    bench.heard()
    bench.set(rts=False).hear(b"data")
    assert bench.heard() == ("" if is_held else "data")
    assert bench.set(rts=True).heard() == ("data" if is_held else "")


def test_a_terminal_that_has_gone_leaves_no_result_code_for_the_next_one() -> None:
    bench = ModemBench().connected(command="AT&K3DT200")
    bench.heard()
    bench.set(dtr=False, rts=False)  # a program closes its serial port
    assert bench.heard() == "\r\nNO CARRIER\r\n"  # sent, though there is no program
    assert bench.set().heard() == ""


def test_xon_and_xoff_stop_either_side() -> None:
    bench = ModemBench().connected(command="AT&K4DT200")
    bench.heard()
    bench.type(b"a" * 2000)
    assert bench.line.take() == [b"\x13"]
    bench.wait(3)
    assert bench.line.take() == [b"\x11"]
    bench.type(b"\x13").hear(b"data").wait(1)
    assert bench.line.take() == []
    assert bench.type(b"\x11").heard() == "data"


def test_a_terminal_that_takes_nothing_stops_the_other_modem() -> None:
    bench = ModemBench().connected()
    bench.heard()
    bench.said()
    bench.set(rts=False)
    for _ in range(6):
        bench.hear(bytes(1000))
    assert bench.said() == [Ready(False)]
    assert bench.set(rts=True).wait(3).heard() == "\0" * 6000
    assert bench.said() == [Ready(True)]


def test_without_error_correction_data_that_nobody_takes_are_lost_in_the_end() -> None:
    bench = ModemBench().connected(correction=0)
    bench.heard()
    bench.said()
    bench.set(rts=False)
    for _ in range(100):
        bench.hear(bytes(1000))
    assert bench.said() == []
    assert len(bench.set(rts=True).wait(30).heard()) == 64 * 1024


def test_the_other_modem_may_stop_the_terminal() -> None:
    bench = ModemBench().connected()
    bench.said()
    bench.hear(Ready(False)).type(MUCH).wait(5)
    assert bench.said() == []
    assert not bench.point("cts")
    bench.hear(Ready(True)).wait(5)
    assert b"".join(message for message in bench.said() if isinstance(message, bytes)) == MUCH


# ---- rate of the serial line


@pytest.mark.manual("PD-245")
def test_the_modem_begins_at_38400_and_follows_the_terminal() -> None:
    bench = ModemBench()
    assert bench.point("baud") == 38_400
    bench.line.deliver(Format(115_200, 7, "E", 1))
    assert bench.line.sent == [Format(115_200, 7, "E", 1)]
    assert bench.point("baud") == 115_200
    bench.line.deliver(Format(12_345))
    assert bench.point("baud") == 115_200


def test_a_rate_that_changes_during_a_call_is_followed_after_it() -> None:
    bench = ModemBench().connected()
    bench.line.deliver(Format(9600))
    assert bench.point("baud") == 38_400
    bench.hear(Heard(Tone.BUSY))
    assert bench.point("baud") == 9600


@pytest.mark.parametrize(
    ("kind", "form"),
    [("0", (8, "E", 1)), ("1", (8, "N", 2)), ("2", (8, "E", 1)), ("2,0", (8, "O", 1)), ("3", (8, "N", 1)),
     ("4", (7, "N", 2)), ("5,1", (7, "E", 1)), ("6", (7, "N", 1))],
)  # fmt: skip
def test_icf_fixes_the_format(kind: str, form: tuple[Any, Any, Any]) -> None:
    """V.250, table 9."""
    bench = ModemBench()
    bench.ask(f"AT+ICF={kind}")
    bench.line.take()
    bench.line.deliver(Format(115_200, 8, "E", 1))
    assert bench.line.take() == [Format(115_200, *form)]


def test_a_fixed_rate_does_not_follow() -> None:
    bench = ModemBench()
    bench.ask("AT+IPR=9600")
    bench.line.deliver(Format(115_200))
    assert bench.point("baud") == 9600


# ---- faults


def test_without_power_all_lines_are_off_and_nothing_is_answered() -> None:
    bench = ModemBench().connected()
    bench.said()
    number = bench.modem.add_fault({"what": "power_off"})
    assert bench.inputs._asdict() == {"cts": False, "dsr": False, "dcd": False, "ri": False}
    assert bench.said() == [Hook(False)]
    assert bench.type("AT\r").hear(Ring(True)).heard() == ""
    bench.modem.clear_fault(number)
    assert bench.inputs.dsr
    assert bench.result("AT") == "OK"


def test_after_a_loss_of_power_the_stored_profile_is_active() -> None:
    bench = ModemBench()
    bench.ask("ATS7=33&W S7=44")
    bench.modem.add_fault({"what": "power_off", "duration_ms": 1000})
    bench.wait(2)
    bench.heard()
    assert bench.lines_of("ATS7?") == ["033", "OK"]


def test_an_unplugged_serial_cable_ends_the_call_by_dtr() -> None:
    bench = ModemBench().connected()
    bench.heard()
    number = bench.modem.add_fault({"what": "serial_unplugged"})
    assert bench.inputs._asdict() == {"cts": False, "dsr": False, "dcd": False, "ri": False}
    assert bench.point("call") == "idle"
    assert bench.type("AT\r").heard() == ""
    bench.modem.clear_fault(number)
    assert bench.inputs.dsr
    assert bench.result("AT") == "OK"


def test_an_unplugged_telephone_line_loses_the_carrier() -> None:
    bench = ModemBench().connected()
    bench.heard()
    bench.said()
    number = bench.modem.add_fault({"what": "line_unplugged"})
    assert bench.said() == [Hook(False)]
    bench.wait(1.4)
    assert bench.heard() == "\r\nNO CARRIER\r\n"
    bench.ask("ATE0")
    bench.type("ATDT1\r").wait(6)
    assert bench.heard() == "\r\nNO DIALTONE\r\n"
    assert bench.said() == []
    bench.modem.clear_fault(number)
    assert bench.ask("ATH1") == "\r\nOK\r\n"
    assert bench.said() == [Hook(True)]


def test_lines_of_the_terminal_are_remembered_while_the_cable_is_out() -> None:
    bench = ModemBench()
    number = bench.modem.add_fault({"what": "serial_unplugged"})
    bench.line.deliver(ControlLines(dtr=False))
    bench.modem.clear_fault(number)
    assert bench.point("dtr") is False
    assert bench.point("rts") is True


def test_the_leds_of_data_are_lit_while_data_pass_and_a_tenth_of_a_second_more() -> None:
    bench = ModemBench().wait(1)

    def leds() -> tuple[bool, bool]:
        return bench.point("sd"), bench.point("rd")

    assert leds() == (False, False)
    bench.type("A")
    assert leds() == (True, True)  # the modem echoes
    bench.ask("TE0")
    assert leds() == (False, False)
    bench.type("A").wait(0.099)
    assert leds() == (True, False)
    bench.wait(0.001)
    assert leds() == (False, False)
    bench.type("T\r").wait(0.05)
    assert leds() == (True, True)  # OK


def test_the_leds_of_data_show_a_call_in_both_directions_and_no_plug_that_is_out() -> None:
    bench = ModemBench().connected().wait(1)
    bench.hear(b"hello").wait(0.01)
    assert (bench.point("sd"), bench.point("rd")) == (False, True)
    bench.wait(0.2).type("hello")
    assert (bench.point("sd"), bench.point("rd")) == (True, False)
    faults = bench.wait(0.2).modem.injected
    assert faults is not None
    faults.add_fault({"what": "serial_unplugged"})
    bench.type("hello").hear(b"hello").wait(0.01)
    assert (bench.point("sd"), bench.point("rd")) == (False, False)
