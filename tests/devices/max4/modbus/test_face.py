"""The controller as a Modbus server: its map, its axes, its diagnosis, seen and moved by pymodbus."""

import re
from pathlib import Path

import pytest
from doc_pages import page_named
from max4_faces_bench import FacesBench, Type

from fieldrig.clock import MS
from fieldrig.errors import ConfigError
from fieldrig_bus.modbus.message import ClientConnected, ModbusMessage, ModbusRequest
from fieldrig_bus.wires import Signal
from fieldrig_devices.max4.axes.axis import Mode
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import Sender
from fieldrig_devices.registers.live import RESERVED

BELT, KNIFE = 1000, 1100
ENABLE, OPERATION, TARGET, SPEED, ACCELERATION, DECELERATION, VELOCITY, TORQUE, COMMAND = 0, 1, 2, 4, 6, 8, 10, 12, 13
AXIS_STATE, MC4_STATE, DIAG_CODE, STATUS, POSITION, ACTUAL_VELOCITY, ACTUAL_TORQUE = 20, 21, 22, 23, 24, 26, 28
START, START_RELATIVE, STOP, FORWARD, BACKWARD, QUIT = 1, 2, 3, 4, 5, 6
OPERATING, ENABLED, CONTROLLED, MOVING, REACHED, ERROR, SIMULATED, FOREIGN = (1 << bit for bit in range(8))
UNIT = 1000
REFUSED = 4


@pytest.fixture
def bench() -> FacesBench:
    return FacesBench("belt", "knife").boot()


@pytest.fixture
def enabled(bench: FacesBench) -> FacesBench:
    assert bench.write(BELT + ENABLE, 1) == 0
    return bench.run(300)


def status(bench: FacesBench, base: int = BELT) -> int:
    value: int = bench.read(base + STATUS)
    return value & ~SIMULATED


def wait(bench: FacesBench, bit: int, most_ms: int = 20_000) -> None:
    for _ in range(most_ms // 20):
        if status(bench) & bit:
            return
        bench.run(20)
    raise AssertionError(f"no {bit:#x}")


# ---- the controller


@pytest.mark.manual("PD-306", "PD-289")
def test_a_foreign_client_reads_the_controller(bench: FacesBench) -> None:
    assert bench.read(0) == 0x4D34
    assert (bench.read(1), bench.read(2), bench.read(3)) == (1, 2, 4)
    assert bench.read(4) == 0x01  # booted, nothing pending, no axis under control
    bench.run(1000)
    assert bench.read(6, Type.UINT32) == pytest.approx(bench.get("Timer1"), abs=5)
    assert bench.read(8, Type.UINT32) == pytest.approx(bench.get("Timer10"), abs=1)
    assert bench.read(10) == bench.get("CycleLoad") != 0
    assert bench.read(11) == bench.get("MsgEntries") != 0
    assert bench.read(12, Type.INT32) == bench.get("RTBReadRes")
    assert bench.read(14, Type.INT32) == bench.get("RTBWriteRes")
    assert bench.read(16, Type.UINT32) == bench.get("Diskfree")
    assert bench.read(80, Type.STRING, 10) == "V00.15.00"


def test_input_registers_are_the_same(bench: FacesBench) -> None:
    assert bench.ask("04 0000 0002") == bench.ask("03 0000 0002").replace("03", "04", 1) == "04 04 4d 34 00 01"


def test_a_block_is_read_in_one_request(bench: FacesBench) -> None:
    for base in (0, 200, BELT, KNIFE):
        assert not bench.client.read_holding_registers(base, count=100).isError()
    assert bench.client.read_holding_registers(100, count=1).isError()
    assert bench.client.read_holding_registers(KNIFE + 100, count=1).isError()


def test_it_is_silent_while_it_boots_or_has_no_power() -> None:
    bench = FacesBench("belt")
    assert bench.ask("03 0000 0001") == ""
    bench.boot()
    assert bench.ask("03 0000 0001") == "03 02 4d 34"
    number = bench.rig.add_fault("max4", {"what": "power_off"})
    assert bench.ask("03 0000 0001") == ""
    bench.rig.clear_fault("max4", number)
    assert bench.boot().ask("03 0000 0001") == "03 02 4d 34"


# As the golden log of the manual has 10.205.10.24, and what else may connect.
PEERS = {
    "10.205.10.24": "0acd0a18",
    "127.0.0.1": "7f000001",
    "::ffff:192.168.1.5": "c0a80105",
    "fe80::1%eth0": "fe80" + "00" * 13 + "01",
}


@pytest.mark.manual("PD-283")
@pytest.mark.parametrize("peer", PEERS)
def test_each_tcp_connection_is_logged_with_the_address_of_the_peer(bench: FacesBench, peer: str) -> None:
    before = bench.codes()
    bench.outside.link("mb").send(ClientConnected(peer))
    bench.outside.link("mb").send(ClientConnected(peer))
    bench.run(1)
    assert bench.codes() == [*before, Code.TCP_CONNECTED, Code.TCP_CONNECTED]
    number, entry = next(iter(bench.max4.firmware.logger.entries()))
    assert entry.line(number).endswith(f"\t0x1000\tLZS\tLZS\t8013\t{PEERS[peer]}\tconnect to TCP/IP server")


@pytest.mark.manual("PD-283")
def test_without_power_no_connection_is_logged(bench: FacesBench) -> None:
    before = bench.codes()
    bench.rig.add_fault("max4", {"what": "power_off"})
    bench.outside.link("mb").send(ClientConnected("10.205.10.24"))
    bench.run(1)
    assert bench.codes() == before


def test_diagnosis_is_read_and_quitted(bench: FacesBench) -> None:
    bench.max4.firmware.report(Code.CYCLE_ERROR, Sender("IEC", "Task1"), "3 ms")
    assert bench.read(5) == 6317
    assert bench.read(4) == 0x03
    assert bench.read(30, Type.STRING, 10) == "3 ms"
    text = bench.client.read_holding_registers(40, count=40).registers
    shown = b"".join(word.to_bytes(2, "big") for word in text).rstrip(b"\x00").decode("latin-1")
    assert shown == bench.get("DiagMsg") == "IEC/Task1: cycle time transgression"
    assert bench.ask("07") == "07 03"
    assert bench.write(20, 1) == 0
    assert (bench.read(5), bench.read(4)) == (0, 0x01)


# Requests and what the specification answers to them; V1.1b3, chapter 6.
ANSWERS = [
    ("03 0000 0000", "83 03"),  # no quantity
    ("03 0000 007e", "83 03"),  # 126
    ("03 0064 0001", "83 02"),  # between the blocks
    ("06 0000 0001", "86 02"),  # the number of the map is read-only
    ("06 0014 0002", "86 04"),  # no such order
    ("10 03e8 0001 02 0002", "90 04"),  # enable is 0 or 1
    ("10 03ec 0002 04 0000 0000", "90 04"),  # no speed
    ("10 03e8 0001 03 0002", "90 03"),  # length
    ("01 0000 0001", "81 02"),  # no outputs are configured
    ("05 0000 1234", "85 03"),
    ("18 0000", "98 02"),
    ("14 00", "94 01"),
    ("2b 0d 00", "ab 01"),
]


@pytest.mark.manual("PD-306")
@pytest.mark.parametrize(("request_", "answer"), ANSWERS)
def test_exceptions(bench: FacesBench, request_: str, answer: str) -> None:
    assert bench.ask(request_) == answer


def test_a_refusal_may_be_exception_3() -> None:
    bench = FacesBench(modbus={"refusal": "illegal_value"}).boot()
    assert bench.ask("06 0014 0002") == "86 03"


def test_it_says_who_it_is(bench: FacesBench) -> None:
    assert bench.ask("2b 0e 04 01") == "2b 0e 04 82 00 00 01 01 05 4d 41 78 2d 34"


def test_another_unit_is_not_ours(bench: FacesBench) -> None:
    assert bench.ask("03 0000 0001", unit=9) == ""


# ---- terminals and parameters


def test_terminals_are_bits() -> None:
    bench = FacesBench(
        inputs={"I_start": "panel.s1", "I_stop": ""},
        outputs={"O_lamp": "panel.h1", "O_horn": ""},
        measuring_inputs={"M_mark": "sensor.mark"},
    ).boot()
    bench.outside.link("wires").send(Signal("panel.s1", True))
    bench.run(1)
    assert bench.client.read_discrete_inputs(0, count=2).bits[:2] == [True, False]
    assert bench.client.read_discrete_inputs(500, count=1).bits[:1] == [False]
    lamps: list[Signal] = []
    bench.outside.link("wires").on_receive(lamps.append, ["panel.h1"])
    bench.client.write_coils(0, [True, True])
    assert bench.client.read_coils(0, count=2).bits[:2] == [True, True]
    assert (bench.get("O_lamp.Value"), bench.get("O_horn.Value")) == (True, True)
    bench.client.write_coil(1, False)
    assert bench.get("O_horn.Value") is False
    assert lamps[-1].value is True


def test_any_parameter_is_reached_by_its_logical_address(bench: FacesBench) -> None:
    parameter = bench.parameter("belt.Position")
    assert bench.write(200, parameter.address, Type.UINT32) == 0
    assert (bench.read(202), bench.read(203), bench.read(204)) == (0, 6, 0)
    assert bench.read(260, Type.STRING, 20) == "Position"
    assert bench.read(280, Type.STRING, 8) == "incr"
    assert bench.write(212, 1.0, Type.FLOAT64) == REFUSED

    filter_ = bench.parameter("MAx-4.General.MsgFilter")
    bench.write(200, filter_.address, Type.UINT32)
    assert (bench.read(202), bench.read(203), bench.read(204)) == (1, 3, 2)
    assert bench.read(210, Type.UINT32) == 0xFFFF
    assert bench.write(210, 0x1001, Type.UINT32) == 0
    assert bench.get("MsgFilter") == 0x1001
    assert bench.write(210, 0x1_0000, Type.UINT32) == REFUSED
    assert bench.write(212, 3.5, Type.FLOAT64) == REFUSED
    assert bench.write(212, 3.0, Type.FLOAT64) == 0
    assert bench.get("MsgFilter") == 3

    bench.write(200, bench.parameter("MAx-4.SoftwareVersion").address, Type.UINT32)
    assert bench.read(216, Type.STRING, 40) == "V00.15.00"
    bench.write(200, bench.axis("belt").log_adr, Type.UINT32)
    assert (bench.read(202), bench.read(260, Type.STRING, 20)) == (2, "belt")
    bench.write(200, 0x7FFF_FFFF, Type.UINT32)
    assert (bench.read(202), bench.read(210, Type.UINT32)) == (3, 0)
    assert bench.write(210, 1, Type.UINT32) == REFUSED


def test_each_bus_has_its_own_window() -> None:
    bench = FacesBench(modbus_buses=("mb", "mb2"), buses={"mb2": {"kind": "modbus.virtual"}}).boot()
    bench.write(200, bench.parameter("MAx-4.General.MsgFilter").address, Type.UINT32)
    heard: list[ModbusMessage] = []
    bench.outside.link("mb2").on_receive(heard.append, ())
    bench.outside.link("mb2").send(ModbusRequest(1, bytes.fromhex("03 00c8 0003"), 1))
    bench.run(10)
    assert heard[0].pdu.hex(" ") == "03 06 00 00 00 00 00 03"


# ---- an axis


def test_an_axis_shows_who_it_is(bench: FacesBench) -> None:
    assert bench.read(KNIFE + 80, Type.STRING, 16) == "knife"
    assert bench.read(KNIFE + 33) == 2
    assert bench.read(KNIFE + 34, Type.UINT32) == bench.axis("knife").log_adr


def test_enable_and_states(bench: FacesBench) -> None:
    assert (bench.read(BELT + AXIS_STATE), bench.read(BELT + MC4_STATE), status(bench)) == (1, 0x10, OPERATING)
    bench.write(BELT + ENABLE, 1)
    bench.run(8)
    assert (bench.read(BELT + AXIS_STATE), bench.read(BELT + MC4_STATE)) == (2, 0x20)
    bench.run(200)
    assert (bench.read(BELT + AXIS_STATE), bench.read(BELT + MC4_STATE)) == (3, 0x21)
    assert status(bench) == OPERATING | ENABLED | CONTROLLED
    assert bench.read(4) == 0x09
    bench.write(BELT + ENABLE, 0)
    bench.run(8)
    assert (bench.read(BELT + AXIS_STATE), bench.read(BELT + ENABLE)) == (1, 0)


@pytest.mark.manual("PD-004", "PD-306")
def test_an_axis_goes_to_a_place_as_the_closed_solution_says(enabled: FacesBench) -> None:
    """3 revolutions at 1 a second, 4 and 5 revolutions per second squared: 0.25 s, 2.775 s, 0.2 s."""
    bench = enabled
    bench.write(BELT + TARGET, 3000, Type.INT32)
    bench.write(BELT + SPEED, 1000, Type.UINT32)
    bench.write(BELT + ACCELERATION, 4000, Type.UINT32)
    bench.write(BELT + DECELERATION, 5000, Type.UINT32)
    places: list[int] = []
    bench.max4.firmware.each_cycle(lambda: places.append(bench.axis("belt").position))
    assert bench.write(BELT + COMMAND, START) == 0
    bench.run(4000)
    first = next(number for number, place in enumerate(places) if place)
    for number, place in enumerate(places[first:], 1):
        t = number * 0.004
        if t <= 0.25:
            wanted = 0.5 * 4e6 * t * t
        elif t <= 3.025:
            wanted = 125_000 + 1e6 * (t - 0.25)
        else:
            wanted = 3e6 - 0.5 * 5e6 * max(3.225 - t, 0) ** 2
        assert place == pytest.approx(wanted, abs=1), t
    assert bench.read(BELT + POSITION, Type.INT32) == 3000
    assert status(bench) == OPERATING | ENABLED | CONTROLLED | REACHED


@pytest.mark.long
@pytest.mark.manual("PD-004")
def test_a_motor_behind_a_drive_on_the_ring_is_moved_and_stopped() -> None:
    plate = str(Path(__file__).parents[4] / "configs" / "plates" / "sm-100-30-080.yaml")
    motor = {"kind": "mc4", "ring_address": 1, "motor": {"name_plate": plate}, "links": {"ring": "ring"}}
    bench = FacesBench(
        buses={"ring": {"kind": "ring.virtual"}}, devices={"mc": motor}, drives={"belt": {"ring_address": 1}}
    )
    bench.boot(10_000)
    bench.write(BELT + ENABLE, 1)
    bench.run(500)
    assert status(bench) == OPERATING | ENABLED | CONTROLLED
    begin = bench.read(BELT + POSITION, Type.INT32)
    bench.write(BELT + TARGET, 2500, Type.INT32)
    bench.write(BELT + COMMAND, START_RELATIVE)
    bench.run(1500)
    assert bench.read(BELT + ACTUAL_VELOCITY, Type.INT32) == pytest.approx(1000, abs=20)
    wait(bench, REACHED)
    bench.run(200)
    assert bench.read(BELT + POSITION, Type.INT32) - begin == pytest.approx(2500, abs=2)


def test_status_and_actual_values_on_the_way(enabled: FacesBench) -> None:
    bench = enabled
    bench.write(BELT + TARGET, -5000, Type.INT32)
    bench.write(BELT + COMMAND, START)
    bench.run(1000)
    assert status(bench) == OPERATING | ENABLED | CONTROLLED | MOVING
    assert bench.read(BELT + ACTUAL_VELOCITY, Type.INT32) == -1000
    assert bench.read(BELT + POSITION, Type.INT32) == pytest.approx(-950, abs=10)
    wait(bench, REACHED)
    assert bench.read(BELT + POSITION, Type.INT32) == -5000


def test_one_request_brings_set_values_and_command(enabled: FacesBench) -> None:
    """Registers 1 to 13 of the block: operation, place, speed, ramps, speed and torque set values, start."""
    words = "0000 000003e8 00000bb8 00002710 00002710 00000000 0000 0001"
    assert enabled.ask(f"10 03e9 000d 1a {words}") == "10 03 e9 00 0d"
    wait(enabled, REACHED)
    assert enabled.axis("belt").position == 1_000_000


def test_ways_add_up_and_a_new_target_turns_the_axis(enabled: FacesBench) -> None:
    bench = enabled
    bench.write(BELT + TARGET, 1000, Type.INT32)
    bench.write(BELT + COMMAND, START_RELATIVE)
    wait(bench, REACHED)
    bench.write(BELT + COMMAND, START_RELATIVE)
    wait(bench, REACHED)
    assert bench.axis("belt").position == 2_000_000
    bench.write(BELT + TARGET, 9000, Type.INT32)
    bench.write(BELT + COMMAND, START)
    bench.run(500)
    bench.write(BELT + TARGET, 0, Type.INT32)
    bench.run(100)
    assert bench.read(BELT + ACTUAL_VELOCITY, Type.INT32) == 1000  # a target waits for its command
    bench.write(BELT + COMMAND, START)
    wait(bench, REACHED)
    assert bench.axis("belt").position == 0


def test_stop_and_jog(enabled: FacesBench) -> None:
    bench = enabled
    bench.write(BELT + COMMAND, FORWARD)
    bench.run(1000)
    assert bench.read(BELT + ACTUAL_VELOCITY, Type.INT32) == 1000
    bench.write(BELT + COMMAND, STOP)
    bench.run(60)
    assert bench.read(BELT + ACTUAL_VELOCITY, Type.INT32) in range(1, 1000)
    bench.run(100)
    assert (bench.read(BELT + ACTUAL_VELOCITY, Type.INT32), status(bench) & (MOVING | REACHED)) == (0, 0)
    place = bench.axis("belt").position
    bench.write(BELT + COMMAND, BACKWARD)
    bench.run(500)
    assert bench.read(BELT + ACTUAL_VELOCITY, Type.INT32) == -1000
    assert bench.axis("belt").position < place


def test_velocity_changes_through_rest(enabled: FacesBench) -> None:
    bench = enabled
    bench.write(BELT + OPERATION, 1)
    bench.write(BELT + VELOCITY, 500, Type.INT32)
    bench.write(BELT + COMMAND, START)
    bench.run(200)
    assert status(bench) & (MOVING | REACHED) == MOVING | REACHED
    bench.write(BELT + VELOCITY, -250, Type.INT32)
    bench.write(BELT + COMMAND, START)
    bench.run(200)
    assert bench.read(BELT + ACTUAL_VELOCITY, Type.INT32) == -250


def test_torque_then_a_place_again(enabled: FacesBench) -> None:
    bench = enabled
    bench.write(BELT + OPERATION, 2)
    bench.write(BELT + TORQUE, -150, Type.INT16)
    bench.write(BELT + COMMAND, START)
    bench.run(20)
    assert (bench.read(BELT + ACTUAL_TORQUE, Type.INT16), bench.axis("belt").mode) == (-150, Mode.TORQUE)
    bench.write(BELT + OPERATION, 0)
    bench.write(BELT + TARGET, 100, Type.INT32)
    bench.write(BELT + COMMAND, START)
    wait(bench, REACHED)
    assert (bench.axis("belt").mode, bench.axis("belt").position) == (Mode.POSITION, 100_000)


def test_no_torque_where_the_telegram_has_none(bench: FacesBench) -> None:
    bench.axis("belt").modes = frozenset({Mode.POSITION})
    assert bench.write(BELT + OPERATION, 2) == REFUSED


def test_an_axis_without_control_refuses_to_move(bench: FacesBench) -> None:
    for command in (START, START_RELATIVE, FORWARD, BACKWARD, 7):
        assert bench.write(BELT + COMMAND, command) == REFUSED
    for command in (0, STOP, QUIT):
        assert bench.write(BELT + COMMAND, command) == 0
    assert bench.read(BELT + COMMAND) == QUIT
    words = "0001 0000 00001388 000003e8 00002710 00002710 00000000 0000 0001"
    assert bench.ask(f"10 03e8 000e 1c {words}") == "90 04"
    assert bench.read(BELT + ENABLE) == 0  # nothing of a refused request is done


def test_losing_control_ends_the_motion(enabled: FacesBench) -> None:
    bench = enabled
    bench.write(BELT + COMMAND, FORWARD)
    bench.run(500)
    bench.write(BELT + ENABLE, 0)
    bench.run(20)
    place = bench.axis("belt").position
    bench.write(BELT + ENABLE, 1)
    bench.run(500)
    assert (bench.axis("belt").position, status(bench) & MOVING) == (place, 0)


def test_an_axis_that_somebody_else_moves_is_stopped_too(enabled: FacesBench) -> None:
    bench, axis = enabled, enabled.axis("belt")

    class Running:
        mode = Mode.POSITION
        place = 0.0

        def begin(self, axis: object) -> None: ...

        def next(self) -> float:
            self.place += 4000
            return self.place

        def end(self) -> None: ...

    axis.follow(Running())
    bench.run(100)
    assert status(bench) & (FOREIGN | MOVING) == FOREIGN
    before = axis.set_value
    bench.write(BELT + COMMAND, STOP)
    bench.run(12)
    assert axis.velocity == pytest.approx(1e6 - 1e7 * 0.012, rel=0.1)  # from its speed on, 10 turns per second squared
    bench.run(300)
    assert axis.velocity == 0
    assert axis.set_value > before
    assert status(bench) & (FOREIGN | MOVING) == 0


def test_positions_count_on_over_32_bits(enabled: FacesBench) -> None:
    bench, axis = enabled, enabled.axis("belt")
    bench.write(BELT + ENABLE, 0)
    bench.run(20)
    axis.position = (2**31 - 100) * UNIT
    bench.write(BELT + ENABLE, 1)
    bench.run(300)
    assert bench.read(BELT + POSITION, Type.INT32) == 2**31 - 100
    bench.write(BELT + TARGET, -(2**31) + 100, Type.INT32)
    bench.write(BELT + COMMAND, START)
    wait(bench, REACHED)
    assert axis.position == (2**31 + 100) * UNIT
    assert bench.read(BELT + POSITION, Type.INT32) == -(2**31) + 100


def test_errors_of_an_axis_are_read_and_quitted(bench: FacesBench) -> None:
    axis = bench.axis("knife")
    bench.max4.firmware.cycles.report_axis(1117, axis)
    assert bench.read(KNIFE + DIAG_CODE) == 1117
    assert status(bench, KNIFE) & ERROR
    assert bench.read(4) & 0x06 == 0x06
    assert bench.read(KNIFE + 40, Type.STRING, 40) == axis.diag_msg
    bench.write(KNIFE + COMMAND, QUIT)
    bench.run(50)
    assert (bench.read(KNIFE + DIAG_CODE), bench.read(5)) == (0, 0)
    assert not status(bench, KNIFE) & ERROR


def test_units_and_word_order_are_settings() -> None:
    modbus = {"increments_per_unit": 100, "units": {"knife": 250_000}, "word_order": "little", "unit_id": 17}
    bench = FacesBench("belt", "knife", modbus=modbus).boot()
    for name in ("belt", "knife"):
        bench.axis(name).position = 25_000_000
    assert bench.ask("03 0400 0002", unit=17) == "03 04 d0 90 00 03"  # 250000 is 0003 D090h
    assert bench.ask("03 0464 0002", unit=17) == "03 04 00 64 00 00"


def test_units_of_no_axis_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"expected names of drives"):
        FacesBench("belt", modbus={"units": {"knife": 100}})


def test_axes_stop_when_no_client_asks_any_more() -> None:
    bench = FacesBench(modbus={"watchdog_ms": 500}).boot()
    bench.write(BELT + ENABLE, 1)
    bench.run(300)
    bench.write(BELT + COMMAND, FORWARD)
    for _ in range(5):
        bench.run(400)
        assert status(bench) & MOVING
    bench.run(450)
    assert bench.axis("belt").velocity == pytest.approx(1e6)
    bench.run(200)
    assert bench.axis("belt").velocity == 0


# ---- the page


def test_the_page_has_the_map(bench: FacesBench) -> None:
    page = page_named("max4-modbus.md").read_text(encoding="utf-8")
    rows = {
        (int(address), name, type)
        for address, name, type in re.findall(
            r"^\| (\d+) \| `([A-Za-z0-9_]+)` \| ([a-z0-9\[\]]+) \|", page, re.MULTILINE
        )
    }
    wanted = {
        (entry.address if entry.address < BELT else entry.address - BELT, entry.name, entry.type)
        for entry in bench.max4._field_buses.modbus_face.entries()
        if entry.name != RESERVED and entry.address < KNIFE
    }
    assert rows == wanted


def test_a_response_leaves_after_the_turnaround_time(bench: FacesBench) -> None:
    asked_ns = bench.rig.now_ns
    bench.ask("03 0000 0001")
    assert bench.rig.now_ns - asked_ns in (2 * MS, 3 * MS)
