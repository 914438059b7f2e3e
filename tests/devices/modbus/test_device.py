"""`modbus.device`: registers by name, tied to wires, with limits, scales, and a memory."""

import json
from pathlib import Path
from typing import Any

import pytest
from full_store import FullStore
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from register_bench import Bench

from fieldrig.clock import MS
from fieldrig.errors import ConfigError, RigError
from fieldrig.storage.store import MemoryStore
from fieldrig_bus.modbus.line import ModbusRtu, ModbusRtuSettings
from fieldrig_bus.modbus.message import LineState, ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.tcp import ModbusTcp, ModbusTcpSettings
from fieldrig_bus.wires import Signal
from fieldrig_devices.modbus.device import ModbusDevice, ModbusDeviceSettings

LAB = Path(__file__).parents[3] / "configs/registers/pump-drive.yaml"
TYPES = """
holding_registers:
  - {address: 0, name: u16}
  - {address: 1, name: s16, type: s16}
  - {address: 2, name: u32, type: u32}
  - {address: 4, name: s32, type: s32, word_order: little}
  - {address: 6, name: f32, type: f32}
  - {address: 8, name: f32l, type: f32, word_order: little}
  - {address: 10, name: u64, type: u64}
  - {address: 14, name: s64, type: s64, word_order: little}
  - {address: 18, name: f64, type: f64}
  - {address: 22, name: flag, type: bool}
  - {address: 23, name: text, type: "string[5]"}
"""
WIRED = """
coils:
  - {address: 0, name: run, wire: pump.run}
  - {address: 1, name: lamp, access: ro, wire: lamp.on}
discrete_inputs:
  - {address: 0, name: running, wire: pump.run}
holding_registers:
  - {address: 0, name: speed, scale: 0.1, unit: "%", min: 0, max: 100, wire: pump.speed}
  - {address: 1, name: torque, type: f32, unit: N.m, max: 50, wire: pump.torque}
input_registers:
  - {address: 0, name: level, scale: 0.001, unit: m, wire: tank.level}
  - {address: 1, name: flow, type: f32, unit: m3/s, wire: tank.inflow}
  - {address: 3, name: cold, type: s16, scale: 0.1, offset: -10, unit: degC, wire: tank.temperature}
  - {address: 4, name: switch, type: bool, wire: tank.high}
fifos:
  - {address: 9, name: levels, depth: 3, wire: tank.level}
"""
RETAINED = """
coils: [{address: 0, name: enabled, retained: true}]
holding_registers:
  - {address: 0, name: limit, type: u32, retained: true, initial: 7}
  - {address: 2, name: other}
"""


@pytest.mark.parametrize(
    ("name", "value", "address", "words"),
    [
        ("u16", 65535, 0, "ffff"),
        ("s16", -2, 1, "fffe"),
        ("u32", 0x12345678, 2, "12345678"),
        ("s32", -2, 4, "fffeffff"),
        ("f32", 1.5, 6, "3fc00000"),
        ("f32l", 1.5, 8, "00003fc0"),
        ("u64", 2**64 - 1, 10, "ffffffffffffffff"),
        ("s64", 0x0123456789ABCDEF, 14, "cdef89ab45670123"),
        ("f64", -2.0, 18, "c000000000000000"),
        ("flag", True, 22, "0001"),
        ("text", "pump", 23, "70756d700000"),
    ],
)
def test_values_stand_in_registers_as_their_type_says(
    tmp_path: Path, name: str, value: Any, address: int, words: str
) -> None:
    bench = Bench(tmp_path, TYPES)
    bench.set(name, value)
    count = len(words) // 4
    assert bench.ask(f"03 {address:04X} {count:04X}") == f"03{2 * count:02x}{words}"
    bench.set(name, {bool: False, str: ""}.get(type(value), 0))
    assert bench.ask(f"10 {address:04X} {count:04X} {2 * count:02X} {words}") == f"10{address:04x}{count:04x}"
    assert bench.point(name) == value


@pytest.mark.parametrize(
    ("name", "value"),
    [("u16", 65536), ("u16", -1), ("s16", 40000), ("u16", "x"), ("u16", True), ("flag", 2), ("text", "too long"),
     ("text", "ü"), ("f32", 1e39), ("u16", float("nan"))],
)  # fmt: skip
def test_a_point_refuses_what_does_not_fit(tmp_path: Path, name: str, value: Any) -> None:
    bench = Bench(tmp_path, TYPES)
    with pytest.raises(ValueError, match=name):
        bench.set(name, value)


@pytest.mark.long
@pytest.mark.parametrize("name", ["u16", "s16", "u32", "s32", "u64", "s64"])
@settings(max_examples=30, deadline=None)
@given(data=st.data())
def test_whole_numbers_come_back(tmp_path_factory: pytest.TempPathFactory, name: str, data: st.DataObject) -> None:
    bits = int(name[1:])
    low, high = (0, 2**bits - 1) if name[0] == "u" else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    bench = Bench(tmp_path_factory.getbasetemp(), TYPES)
    value = data.draw(st.integers(low, high))
    bench.set(name, value)
    assert bench.point(name) == value


def test_a_write_drives_its_wire_and_a_wire_its_register(tmp_path: Path) -> None:
    bench = Bench(tmp_path, WIRED)
    assert bench.wires.interest == ["lamp.on", "pump.run", "tank.high", "tank.inflow", "tank.level", "tank.temperature"]
    assert bench.wires.take() == [
        Signal("pump.run", False),
        Signal("pump.speed", 0.0, "%"),
        Signal("pump.torque", 0.0, "N.m"),
    ]
    bench.ask("05 0000 FF00")
    bench.ask("06 0000 01F4")
    assert bench.wires.take() == [Signal("pump.run", True), Signal("pump.speed", 50.0, "%")]
    assert bench.ask("02 0000 0001") == "020101"  # what it drives itself it also hears
    bench.wires.deliver(Signal("tank.level", 1.2344, "m"))
    bench.wires.deliver(Signal("tank.inflow", 0.25, "m3/s"))
    bench.wires.deliver(Signal("tank.temperature", -12.5, "degC"))
    bench.wires.deliver(Signal("tank.high", True))
    bench.wires.deliver(Signal("lamp.on", True))
    assert bench.ask("04 0000 0005") == "040a" + "04d2" + "3e800000" + "ffe7" + "0001"
    assert bench.ask("01 0000 0002") == "010103"
    assert bench.device.points()["level"].write is None


def test_a_value_of_two_registers_takes_effect_with_its_last(tmp_path: Path) -> None:
    bench = Bench(tmp_path, WIRED)
    bench.wires.take()
    bench.ask("06 0001 4120")
    assert bench.wires.take() == []
    bench.ask("06 0002 0000")
    assert bench.wires.take() == [Signal("pump.torque", 10.0, "N.m")]
    assert bench.ask("10 0001 0002 04 42480001") == "9004"  # a little more than 50
    assert bench.ask("10 0001 0002 04 7FC00000") == "9004"  # not a number
    assert bench.ask("10 0001 0002 04 42480000") == "1000010002"


@pytest.mark.parametrize(
    ("out_of_range", "answer", "stands"),
    [("server_failure", "8604", "0000"), ("illegal_value", "8603", "0000"), ("limit", "06000003e9", "03e8")],
)
def test_a_write_beyond_the_limits_is_answered_as_set(
    tmp_path: Path, out_of_range: str, answer: str, stands: str
) -> None:
    bench = Bench(tmp_path, WIRED, out_of_range=out_of_range)
    assert bench.ask("06 0000 03E9") == answer
    assert bench.ask("03 0000 0001") == "0302" + stands


def test_a_reading_beyond_the_register_shows_its_end(tmp_path: Path) -> None:
    bench = Bench(tmp_path, WIRED)
    for level, shown in ((100.0, "ffff"), (-1.0, "0000")):
        bench.wires.deliver(Signal("tank.level", level, "m"))
        assert bench.ask("04 0000 0001") == "0402" + shown
    for temperature, shown in ((1e9, "7fff"), (-1e9, "8000")):
        bench.wires.deliver(Signal("tank.temperature", temperature, "degC"))
        assert bench.ask("04 0003 0001") == "0402" + shown
    for flow, shown in ((1e300, "7f7fffff"), (-1e300, "ff7fffff")):
        bench.wires.deliver(Signal("tank.inflow", flow, "m3/s"))
        assert bench.ask("04 0001 0002") == "0404" + shown


def test_a_wire_in_another_unit_is_not_taken_over(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    bench = Bench(tmp_path, WIRED)
    for _ in range(2):
        bench.wires.deliver(Signal("tank.level", 1234, "mm"))
    assert bench.ask("04 0000 0001") == "04020000"
    assert caplog.text.count("expected the unit 'm', got 'mm' on tank.level") == 1


def test_a_fifo_takes_what_changes_on_its_wire_and_forgets_the_oldest(tmp_path: Path) -> None:
    bench = Bench(tmp_path, WIRED)
    for level in (1.0, 1.2, 2.0, 3.0, 4.0):
        bench.wires.deliver(Signal("tank.level", level, "m"))
    assert bench.ask("18 0009") == "18" + "0008" + "0003" + "0002" + "0003" + "0004"
    bench.set("levels", 9)
    assert bench.ask("18 0009") == "18" + "0008" + "0003" + "0003" + "0004" + "0009"


def test_the_response_leaves_after_the_turnaround_time(tmp_path: Path) -> None:
    bench = Bench(tmp_path, WIRED, turnaround_ms=3.5)
    assert bench.ask("06 0000 0001") is None
    assert bench.point("speed") == 0.1
    bench.clock.advance_to(int(3.5 * MS) - 1)
    assert bench.tcp.take() == []
    bench.clock.advance_to(int(3.5 * MS))
    assert bench.tcp.take() == [ModbusResponse(1, bytes.fromhex("0600000001"), 5)]


def test_the_turnaround_time_is_realistic_unless_set(tmp_path: Path) -> None:
    assert Bench(tmp_path, WIRED, turnaround_ms=None).settings.turnaround_ms == 2.0


def test_what_is_retained_survives_a_kill_and_the_rest_does_not(tmp_path: Path) -> None:
    first = Bench(tmp_path, RETAINED)
    first.ask("10 0000 0003 06 0001 0002 0009")
    first.ask("05 0000 FF00")
    second = Bench(tmp_path, RETAINED, first.store)
    assert second.ask("03 0000 0003") == "0306" + "0001" + "0002" + "0000"
    assert second.ask("01 0000 0001") == "010101"
    second.set("limit", 8)
    assert Bench(tmp_path, RETAINED, first.store).point("limit") == 8


def test_what_is_retained_is_saved_before_the_answer(tmp_path: Path) -> None:
    bench = Bench(tmp_path, RETAINED)
    saved_when_sent: list[bytes | None] = []
    bench.tcp.send = lambda message: saved_when_sent.append(bench.store.load())  # type: ignore[method-assign]
    device = ModbusDevice(bench.clock, bench.settings, [bench.tcp], bench.store)
    device.start()
    bench.tcp.deliver(ModbusRequest(1, bytes.fromhex("06 0001 0005")))
    assert saved_when_sent == [b'{"1": {"enabled": "00", "limit": "00000005"}}']


@pytest.mark.parametrize(
    "kept", [b"", b"{", b"[]", b'{"1": 3}', b'{"1": {"limit": "zz000000"}}', b'{"9": {}}', b'{"1": {"limit": "00"}}']
)
def test_a_memory_that_can_not_be_read_is_given_up(tmp_path: Path, kept: bytes) -> None:
    assert Bench(tmp_path, RETAINED, MemoryStore(kept)).point("limit") == 7


def test_several_units_have_registers_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("holding_registers: [{address: 0, name: a, initial: 1}]")
    (tmp_path / "b.yaml").write_text("holding_registers: [{address: 0, name: b, initial: 2}]")
    units = {1: {"table": "a.yaml"}, 7: {"table": "b.yaml", "server_id": {"server_id": "AA", "additional": ""}}}
    bench = Bench(tmp_path, None, units=units, server_id={"server_id": "BB", "additional": ""})
    assert bench.tcp.interest == bench.rtu.interest == [1, 7]
    assert (bench.ask("03 0000 0001", 1), bench.ask("03 0000 0001", 7)) == ("03020001", "03020002")
    assert (bench.ask("11", 1), bench.ask("11", 7)) == ("1102bbff", "1102aaff")
    assert sorted(bench.device.points()) == ["1/a", "7/b"]
    assert bench.ask("06 0000 0009", 0, LineState(1)) is None
    assert (bench.point("1/a"), bench.point("7/b")) == (9, 9)


def test_each_bus_has_counters_and_a_listen_only_mode_of_its_own(tmp_path: Path) -> None:
    bench = Bench(tmp_path, RETAINED)
    assert bench.ask("08 0004 0000", line=LineState(1)) is None
    assert bench.ask("03 0000 0001", line=LineState(1)) is None
    assert bench.ask("03 0000 0001") == "03020000"


def test_the_exception_status_may_be_bits_by_name(tmp_path: Path) -> None:
    bench = Bench(tmp_path, WIRED, exception_status=["lamp", "run", "switch"])
    bench.ask("05 0000 FF00")
    assert bench.ask("07") == "0702"
    bench.wires.deliver(Signal("tank.high", True))
    assert bench.ask("07") == "0706"
    with pytest.raises(RigError, match="exception_status: unknown unknown_bit"):
        Bench(tmp_path, WIRED, exception_status=["unknown_bit"])


def test_exactly_one_form_of_units_is_given(tmp_path: Path) -> None:
    with pytest.raises(ValidationError, match="either table"):
        ModbusDeviceSettings.model_validate({})
    with pytest.raises(ValidationError):
        ModbusDeviceSettings.model_validate({"table": str(LAB), "unit_id": 248})
    (tmp_path / "wrong.yaml").write_text("coils: [{address: -1, name: a}]")
    with pytest.raises(ConfigError):
        Bench(tmp_path, tmp_path / "wrong.yaml")


def test_the_lab_s_drive_runs_the_pump_and_shows_the_tank(tmp_path: Path) -> None:
    bench = Bench(tmp_path, LAB)
    bench.ask("05 0000 FF00")
    bench.ask("06 0000 02EE")
    assert {signal.name: signal.value for signal in bench.wires.take()} == {"pump.run": True, "pump.speed": 75.0}
    bench.wires.deliver(Signal("tank.level", 0.5, "m"))
    bench.wires.deliver(Signal("tank.high", True))
    bench.wires.deliver(Signal("tank.inflow", 0.00075, "m3/s"))
    assert bench.ask("04 0000 0002") == "0404" + "01f4" + "02ee"
    assert bench.ask("02 0000 0002") == "020103"
    assert bench.point("flow") == pytest.approx(0.00075)


def test_tools_read_every_register_with_mbpoll(tmp_path: Path) -> None:
    bus = ModbusTcp("mb", ModbusTcpSettings(listen="127.0.0.1:5020"))
    settings = ModbusDeviceSettings(table=LAB)
    *lines, read, start = [tool.line for tool in ModbusDevice.tools("drive", settings, {"modbus": [bus]})]
    assert "print(c.read_input_registers(2, count=2, device_id=1)); " in read
    assert "print(c.write_coil(0, True, device_id=1)); " in start
    assert lines == [
        "mbpoll -m tcp -p 5020 -a 1 -t 0 -0 -r 0 -c 2 -1 127.0.0.1",
        "mbpoll -m tcp -p 5020 -a 1 -t 1 -0 -r 0 -c 2 -1 127.0.0.1",
        "mbpoll -m tcp -p 5020 -a 1 -t 4 -0 -r 0 -c 11 -1 127.0.0.1",
        "mbpoll -m tcp -p 5020 -a 1 -t 3 -0 -r 0 -c 2 -1 127.0.0.1",
        "mbpoll -m tcp -p 5020 -a 1 -t 3:float -B -0 -r 2 -c 1 -1 127.0.0.1",
        "mbpoll -m tcp -p 5020 -a 1 -t 3 -0 -r 4 -c 1 -1 127.0.0.1",
        "mbpoll -m tcp -p 5020 -a 1 -t 0 -0 -r 0 127.0.0.1 1",
    ]


def test_tools_of_a_line_ask_for_what_the_table_has(tmp_path: Path) -> None:
    """A meter without register 0 gets no line that reads register 0."""
    table = tmp_path / "meter.yaml"
    table.write_text("input_registers: [{address: 40, name: voltage, type: u16, unit: V, scale: 0.1}]")
    bus = ModbusRtu("line", ModbusRtuSettings(pty="meter", baud=9600))
    settings = ModbusDeviceSettings(table=table, unit_id=3)
    assert [tool.line for tool in ModbusDevice.tools("meter", settings, {"modbus": [bus]})] == [
        "mbpoll -m rtu -b 9600 -P none -s 1 -a 3 -t 3 -0 -r 40 -c 1 -1 {run}/meter",
        (
            'python -c "from pymodbus import FramerType; from pymodbus.client import ModbusSerialClient; '
            "c = ModbusSerialClient('{run}/meter', framer=FramerType.RTU, baudrate=9600, parity='N', bytesize=8); "
            'c.connect(); print(c.read_input_registers(40, count=1, device_id=3)); c.close()"'
        ),
    ]


def test_tools_on_two_buses_say_which_is_which(tmp_path: Path) -> None:
    buses = [
        ModbusTcp("mb_tcp", ModbusTcpSettings(listen="127.0.0.1:5020")),
        ModbusRtu("mb_rtu", ModbusRtuSettings(pty="line")),
    ]
    labels = [tool.label for tool in ModbusDevice.tools("drive", ModbusDeviceSettings(table=LAB), {"modbus": buses})]
    assert len(labels) == len(set(labels)) == 18
    assert {label.rpartition(" by ")[2] for label in labels} == {"mb_tcp", "mb_rtu"}


# ---- the non-volatile memory


LIMITED = """
coils: [{address: 0, name: enabled, retained: true, wire: pump.enable}, {address: 1, name: other}]
holding_registers:
  - {address: 0, name: seconds, type: u32, retained: true, scale: 0.1, min: 0, max: 600, initial: 5, wire: t.s, unit: s}
  - {address: 2, name: plain, initial: 9}
"""


@pytest.mark.parametrize(
    ("request_", "refused", "accepted"),
    [
        ("05 0000 FF00", "8504", "050000ff00"),
        ("0F 0000 0002 01 03", "8f04", "0f00000002"),
        ("10 0000 0002 04 0000 0064", "9004", "1000000002"),
        ("10 0000 0003 06 0000 0064 0001", "9004", "1000000003"),
        ("17 0000 0001 0000 0002 04 0000 0064", "9704", "17020000"),
        ("06 0001 0064", "8604", "0600010064"),
        ("16 0001 0000 0064", "9604", "16000100000064"),
    ],
)
def test_a_write_that_can_not_be_kept_is_exception_04_and_changes_nothing(
    tmp_path: Path, request_: str, refused: str, accepted: str
) -> None:
    store = FullStore()
    bench = Bench(tmp_path, LIMITED, store)
    assert len(bench.wires.take()) == 2  # the initial values were sent to the wires
    for _ in range(2):
        assert bench.ask(request_) == refused
    assert (bench.ask("03 0000 0003"), bench.ask("01 0000 0002")) == ("0306" + "0000" + "0032" + "0009", "010100")
    assert bench.wires.take() == []
    assert bench.ask("06 0002 0007") == "0600020007"  # what is not retained goes on
    store.is_full = False
    assert bench.ask(request_) == accepted
    assert len(bench.wires.take()) == 1


def test_a_broadcast_that_can_not_be_kept_changes_nothing(tmp_path: Path) -> None:
    bench = Bench(tmp_path, LIMITED, FullStore())
    assert bench.ask("06 0001 0064", 0, LineState(1)) is None
    assert bench.point("seconds") == 5


def test_a_point_that_can_not_be_kept_is_refused_with_its_reason(tmp_path: Path) -> None:
    bench = Bench(tmp_path, LIMITED, FullStore())
    with pytest.raises(ValueError, match="seconds cannot be stored: No space left on device"):
        bench.set("seconds", 7)
    assert bench.point("seconds") == 5


def test_a_value_written_in_halves_is_kept_when_it_is_whole(tmp_path: Path) -> None:
    bench = Bench(tmp_path, LIMITED)
    bench.ask("06 0000 0001")  # the high word: 6553.6 s, were it whole
    bench.ask("05 0000 FF00")
    again = Bench(tmp_path, LIMITED, bench.store)
    assert (again.point("seconds"), again.point("enabled")) == (5, True)


@pytest.mark.parametrize("damaged", ["0000b700", "ffffffff"])
def test_a_stored_value_beyond_its_limits_gives_the_previous_version(tmp_path: Path, damaged: str) -> None:
    bench = Bench(tmp_path, LIMITED)
    bench.set("seconds", 60)
    store = bench.store
    store.save(json.dumps({"1": {"seconds": damaged, "enabled": "01"}}).encode())
    again = Bench(tmp_path, LIMITED, store)
    assert (again.point("seconds"), again.point("enabled")) == (60, False)
    store.save(json.dumps({"1": {"seconds": damaged}}).encode())
    assert Bench(tmp_path, LIMITED, store).point("seconds") == 5  # both are damaged


def test_a_value_equal_to_the_initial_one_is_kept_too(tmp_path: Path) -> None:
    bench = Bench(tmp_path, RETAINED)
    bench.ask("10 0000 0002 04 0000 0007")
    assert Bench(tmp_path, RETAINED.replace("initial: 7", "initial: 8"), bench.store).point("limit") == 7
