"""The controller with the emulated modem at COM1: the troubleshooting table of PacDrive manual 7.2.5."""

from typing import Any, Self

import pytest
from max4_rig import Max4Rig

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_bus.serial.message import Format
from fieldrig_devices.dial.caller import Caller, Plan
from fieldrig_devices.ppp.settings import Login

LOGIN = Login.of("service", "pacdrive")
TOOL_LIMIT_S = 4
"""A time limit of a tool, such as that of ping (PD-287); the manual gives none for EPAS_StandardTimeout."""
LONG_TOOL_LIMIT_S = 10
"""EPAS_StandardTimeout as the manual has it raised (PD-261)."""


class Line(Max4Rig):
    """A controller with its modem (number 4711), and a caller at another one.  `modem` has settings of the former."""

    def __init__(
        self, modem: dict[str, Any] | None = None, far: dict[str, Any] | None = None, **parameters: Any
    ) -> None:
        values = {"MAx-4.Com1User": 1, "Phone.UserName": "service", "Phone.Password": "pacdrive"}
        values |= {name.replace("__", "."): value for name, value in parameters.items()}
        buses = {
            "com1": {"kind": "serial.virtual", "baud": 38_400},
            "laptop": {"kind": "serial.virtual", "baud": 38_400, "garbling": True},
            "telephone": {"kind": "telephone.virtual", "numbers": {"near": "4711", "far": "4712"}},
        }
        devices = {
            "max4": {
                "kind": "max4",
                "links": {"com1": "com1"},
                "com1": {"modem": "Phone"},
                "drives": {"belt": {"ring_address": 1, "simulated": True}},
                "parameters": values,
            },
            "near": {"kind": "modem", "links": {"line": "com1", "telephone": "telephone"}, **(modem or {})},
            "far": {"kind": "modem", "links": {"line": "laptop", "telephone": "telephone"}, **(far or {})},
        }
        self.rig = Rig(from_dict({"time": "virtual", "seed": 7, "buses": buses, "devices": devices}))
        self._line = self.rig.attach("caller").link("laptop")
        self._line.on_receive(lambda data: self.caller.receive(self.rig.now_ns, data))
        self.caller = self._new(LOGIN)

    def _new(self, login: Login, **plan: Any) -> Caller:
        return Caller(Plan("4711", login=login, **plan), lambda: 0x1234_5678, self._line.send, lambda _: None)

    def call(self, login: Login = LOGIN, **plan: Any) -> Self:
        """Dial, and wait until the link is up, or the call has failed."""
        self.dial(login, **plan)
        while not self.caller.is_up and not self.caller.is_over:
            self.go(100)
        return self

    def dial(self, login: Login = LOGIN, **plan: Any) -> Self:
        self.caller = self._new(login, **plan)
        self.caller.start(self.rig.now_ns)
        return self

    def send(self, message: Format) -> None:
        """The laptop opens its port in another format."""
        self._line.send(message)

    @property
    def failure(self) -> str:
        """The reason why the call is over, as the caller sees it; empty without one."""
        return self.caller.failure.what if self.caller.failure is not None else ""

    def go(self, ms: int) -> Self:
        end_ns = self.rig.now_ns + ms * MS
        while self.rig.now_ns < end_ns:
            self.rig.run_until(min(end_ns, self.rig.now_ns + 2 * MS))
            self.caller.advance(self.rig.now_ns)
        return self

    @property
    def states(self) -> tuple[Any, Any]:
        """Com1UserState, and State of the Modem object."""
        return self.get("Com1UserState"), self.get("Phone.State")


@pytest.mark.long
@pytest.mark.manual("PD-246")
@pytest.mark.manual("PD-248")
def test_the_default_strings_set_the_modem_up_and_a_call_is_answered_after_two_rings() -> None:
    line = Line().go(5000)
    assert line.states == (6, 2)
    assert not line.rig.get("near", "dcd")
    assert line.call().caller.is_up
    assert line.states == (7, 3)
    assert line.rig.get("near", "dcd")


@pytest.mark.long
@pytest.mark.manual("PD-270")
@pytest.mark.parametrize(
    ("parameters", "states"),
    [
        ({"MAx-4__Com1User": 0}, (1, 0)),
        ({"Phone__InitString": "AT&F E0 X99"}, (2, 5)),
        ({"Phone__ExpInitString": "AT S999999=1"}, (2, 8)),
    ],
)
def test_a_wrong_parameter_leaves_the_call_unanswered(parameters: dict[str, Any], states: tuple[int, int]) -> None:
    line = Line(**parameters).go(12_000)
    assert line.states == states
    assert line.call().caller.failure is not None


@pytest.mark.long
@pytest.mark.manual("PD-270")
def test_a_modem_without_rockwell_chip_set_needs_at_as_second_string() -> None:
    assert Line({"chip_set": "other"}).go(12_000).states == (2, 8)
    line = Line({"chip_set": "other"}, Phone__ExpInitString="AT").go(12_000)
    assert line.states == (6, 2)
    assert line.call().caller.is_up


@pytest.mark.long
@pytest.mark.manual("PD-270")
@pytest.mark.parametrize("what", ["power_off", "serial_unplugged"])
def test_a_modem_that_is_off_or_unplugged_is_noticed_and_found_again(what: str) -> None:
    line = Line().go(5000)
    fault = line.rig.add_fault("near", {"what": what})
    assert line.go(3000).states == (2, 1)
    line.rig.clear_fault("near", fault)
    assert line.go(15_000).states == (6, 2)
    assert line.call().caller.is_up


@pytest.mark.long
@pytest.mark.manual("PD-270")
@pytest.mark.manual("PD-252")
@pytest.mark.parametrize(("after", "state"), [(0, 6), (4, 9)])
def test_a_miswired_modem_times_out_until_it_is_switched_off_and_on(after: int, state: int) -> None:
    """The modem is there (DSR), but with the wrong cable it never answers InitString or ExpInitString."""
    line = Line()
    while line.states[1] != after:
        line.go(10)
    fault = line.rig.add_fault("near", {"what": "serial_miswired"})
    assert line.go(15_000).states == (2, state)
    line.rig.clear_fault("near", fault)
    assert line.go(15_000).states == (2, state)
    line.rig.add_fault("near", {"what": "power_off", "duration_ms": 2000})
    assert line.go(20_000).states == (6, 2)
    assert line.call().caller.is_up


@pytest.mark.long
@pytest.mark.manual("PD-274")
@pytest.mark.parametrize(("bps", "is_in_time"), [(33_600, True), (9600, True), (2400, False)])
def test_a_slow_link_carries_no_complete_packet_within_the_time_limit_of_a_tool(bps: int, is_in_time: bool) -> None:
    """Cause 2: below 9600 bit/s an answer is not complete in time, and a longer limit is what helps."""
    line = Line(far={"highest_bps": bps}).go(5000).call()
    begin_ns, page = line.rig.now_ns, bytearray()
    connection = line.caller.open(80)
    connection.on_data = page.extend
    connection.send(b"GET /INDEX.HTM HTTP/1.1\r\nHost: plc\r\nConnection: close\r\n\r\n")
    while connection.is_open and not connection.incoming.has_ended:
        line.go(50)
    assert page.endswith(b"</html>\n")
    assert (line.rig.now_ns - begin_ns < TOOL_LIMIT_S * S) is is_in_time
    assert line.rig.now_ns - begin_ns < LONG_TOOL_LIMIT_S * S


@pytest.mark.long
@pytest.mark.manual("PD-270")
def test_without_auto_answer_the_telephone_rings_on() -> None:
    line = Line(Phone__InitString="AT&F E0 Q0 V1 &S0 &C1 &R0 S0=0").go(5000)
    assert line.states == (6, 2)
    assert line.call().caller.failure is not None
    assert line.states == (6, 2)


def offline_again(line: Line) -> bool:
    """The controller waits for the next call, and answers it."""
    return line.go(60_000).states == (6, 2) and line.call().caller.is_up


@pytest.mark.long
@pytest.mark.manual("PD-271")
def test_a_caller_with_a_short_time_out_gives_up_before_the_modems_are_connected() -> None:
    line = Line().go(5000).call(dial_ns=5 * S)
    assert line.failure == "The modem did not connect in time."
    assert line.states == (6, 2)
    assert offline_again(line)


@pytest.mark.long
@pytest.mark.manual("PD-272")
def test_modems_that_are_set_to_different_speeds_have_no_carrier() -> None:
    slow = ("AT&F E0 Q0 V1 X4 &C1 &D2", "AT+MS=V32B,0,4800,14400")
    line = Line(Phone__ExpInitString="AT+MS=V34,0,19200,33600").go(5000).call(init=slow)
    assert line.failure.startswith("There is no carrier")
    assert offline_again(line)


@pytest.mark.long
@pytest.mark.manual("PD-272")
def test_a_poor_line_without_error_correction_carries_no_handshake() -> None:
    line = Line(Phone__InitString="AT&F E0 Q0 V1 &S0 &C1 &R0 S0=2 \\N0").go(5000)
    fault = line.rig.add_fault("telephone", {"what": "noise", "bit_error_rate": 0.05})
    line.call(init=("AT&F E0 Q0 V1 X4 &C1 &D2", "AT\\N0"))
    assert line.failure == "No PPP answers at the other end."
    line.rig.clear_fault("telephone", fault)
    assert offline_again(line)


@pytest.mark.long
@pytest.mark.manual("PD-273")
def test_a_caller_whose_format_is_not_8n1_gets_no_link() -> None:
    line = Line().go(5000).dial()
    while line.rig.get("far", "call") != "connected":
        line.go(10)
    line.send(Format(38_400, 7, "E", 1))
    while not line.caller.is_over:
        line.go(100)
    assert line.failure == "No PPP answers at the other end."
    line.send(Format(38_400))
    assert offline_again(line)


@pytest.mark.long
@pytest.mark.manual("PD-275")
def test_pulses_of_a_charge_meter_that_are_too_long_lose_the_connection() -> None:
    line = Line().go(5000).call()
    pulses = {"what": "dropout", "period_ms": 10_000, "length_ms": 2000}
    fault = line.rig.add_fault("telephone", pulses)
    line.go(15_000)
    assert (line.failure, line.states) == ("The connection was lost.", (6, 2))
    line.rig.clear_fault("telephone", fault)
    assert offline_again(line)


@pytest.mark.long
@pytest.mark.manual("PD-275")
def test_a_controller_that_boots_loses_the_connection_and_is_called_again_some_seconds_later() -> None:
    line = Line().go(5000).call()
    line.set("command", "system reset").go(3000)
    assert line.failure == "The connection was lost."
    assert offline_again(line)


@pytest.mark.long
@pytest.mark.manual("PD-275")
def test_a_client_that_ends_an_idle_connection_leaves_the_controller_ready() -> None:
    line = Line().go(5000).call()
    line.caller.hang_up(line.rig.now_ns)
    line.go(10_000)
    assert (line.failure, line.states) == ("", (6, 2))
    assert offline_again(line)


@pytest.mark.long
@pytest.mark.manual("PD-273")
def test_a_wrong_password_drops_the_call_at_the_password_check() -> None:
    line = Line().go(5000).call(Login.of("service", "wrong"))
    assert line.caller.failure is not None
    assert "password" in line.caller.failure.what
    assert line.go(8000).states == (6, 2)
    assert line.call().caller.is_up


@pytest.mark.long
@pytest.mark.manual("PD-275")
@pytest.mark.parametrize("where", ["near", "far"])
def test_a_call_is_lost_with_either_modem_and_the_next_one_is_answered(where: str) -> None:
    line = Line().go(5000).call()
    fault = line.rig.add_fault(where, {"what": "line_unplugged"})
    line.go(5000)
    assert line.states == (6, 2)
    line.rig.clear_fault(where, fault)
    line.go(20_000)
    assert line.call().caller.is_up
