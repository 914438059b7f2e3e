"""Rows of the PacDrive digest about the system as a whole: what the controller has, tells, and how exact it is."""

from itertools import pairwise
from typing import Any

import pytest
from max4_bench import MAX4, MC4, PLATE, Bench
from ring_lab import RingLab

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, US
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.ring.sercos.message import Answers, Cycle
from fieldrig_bus.wires import Signal
from fieldrig_devices.max4.axes.axis import Mode
from fieldrig_devices.max4.configuration.limits import limits_of
from fieldrig_devices.max4.configuration.version import Version


@pytest.mark.long
@pytest.mark.manual("PD-003")
def test_controller_has_its_interfaces_all_at_once() -> None:
    """Ethernet, two serial ones, a field bus module, digital I/O and the drive bus; analog I/O has no object in the
    manual's configuration, and OPC and PROFIBUS are others' affair."""
    lines = {name: {"kind": "modbus.virtual", "mode": mode} for name, mode in (("com1", "rtu"), ("com2", "rtu"))}
    buses: dict[str, Any] = {
        "ring": {"kind": "ring.virtual"},
        "ethernet": {"kind": "modbus.virtual"},
        **lines,
        "can0": {"kind": "can.virtual", "bitrate": 1_000_000},
        "wires": {"kind": "wires.virtual"},
    }
    max4 = {
        "kind": MAX4,
        "links": {"ring": "ring", "modbus": ["ethernet", "com1", "com2"], "can": "can0", "wires": "wires"},
        "drives": {"belt": {"ring_address": 1}},
        "can_axes": {"node_ids": [1]},
        "inputs": {"I_bStartS1": "panel.s1"},
        "outputs": {"O_bLampH1": "panel.h1"},
    }
    belt = {"kind": MC4, "ring_address": 1, "motor": {"name_plate": PLATE}, "links": {"ring": "ring"}}
    heard: dict[str, set[str]] = {}
    answers: list[tuple[str, ModbusResponse]] = []
    lamps: list[object] = []
    device_types: list[bytes] = []

    def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        match delivery.message:
            case ModbusResponse() as answer:
                answers.append((bus.name, answer))
            case Signal(name="panel.h1", value=value):
                lamps.append(value)
            case CanFrame(identifier=0x581, data=data):
                device_types.append(data)
        heard.setdefault(bus.name, set()).add(delivery.sender)

    config = from_dict({"time": "virtual", "buses": buses, "devices": {"max4": max4, "belt": belt}})
    rig = Rig(config, on_delivery)
    outside = rig.attach("outside")
    rig.run_until(4_000 * MS)
    for name in ("ethernet", "com1", "com2"):
        outside.link(name).send(ModbusRequest(1, bytes.fromhex("03 0000 0001"), 7))
    outside.link("wires").send(Signal("panel.s1", True))
    rig.set("max4", "O_bLampH1.Value", True)
    rig.run_until(4_500 * MS)
    outside.link("can0").send(CanFrame(0x601, bytes.fromhex("40 00 10 00 00 00 00 00")))
    rig.run_until(4_600 * MS)
    assert rig.get("max4", "I_bStartS1.Value") is True
    assert all("max4" in heard[name] for name in buses), {name: sorted(heard[name]) for name in heard}
    assert (rig.get("max4", "ring.state"), rig.get("max4", "belt.MC4State")) == ("up", 0x10)
    assert lamps == [False, True]
    answered = [(name, message.pdu[:2].hex()) for name, message in answers]
    assert sorted(answered) == [("com1", "0302"), ("com2", "0302"), ("ethernet", "0302")]
    assert device_types == [bytes.fromhex("43 00 10 00 92 01 ff ff")]


@pytest.mark.manual("PD-023")
def test_objects_have_their_types_by_the_configuration() -> None:
    bench = Bench(
        "knife",
        inputs={"I_bS1": ""},
        outputs={"O_bH1": ""},
        measuring_inputs={"M_1": ""},
        logic_encoders=["MasterEncoder"],
        master_encoders={"BeltEncoder": ""},
    )
    tree = bench.run(100).max4.firmware.tree
    types = {entry.symbol: entry.type_name for entry in tree.objects() if entry.symbol}
    assert {name: types[name] for name in ("knife", "I_bS1", "O_bH1", "M_1", "MasterEncoder", "BeltEncoder")} == {
        "knife": "MC_4",
        "I_bS1": "D_IN",
        "O_bH1": "D_OUT",
        "M_1": "M_IN",
        "MasterEncoder": "LOGIC_ENC",
        "BeltEncoder": "MASTER_ENC",
    }


@pytest.mark.manual("PD-070")
def test_inputs_and_outputs_are_not_kept_in_an_image() -> None:
    """They change between two cycles of the real-time process, at the moment of access."""
    bench = Bench(inputs={"I_bS1": "panel.s1"}, outputs={"O_bH1": "panel.h1"}).boot().run(1)
    cycles = bench.get("cycles")
    for is_on in (True, False, True):
        bench.signal("panel.s1", is_on).run(0.1)
        assert bench.get("I_bS1.Value") is is_on
        now_ns = bench.rig.now_ns
        bench.set("O_bH1.Value", is_on).run(0.1)
        assert bench.wires[-1] == (now_ns, "panel.h1", is_on)
    assert bench.get("cycles") == cycles


class _Steady:
    """Increments per cycle."""

    def __init__(self, way: int) -> None:
        self.mode, self._way, self._place = Mode.POSITION, way, 0

    def begin(self, axis: Any) -> None:
        self._place = axis.position

    def next(self) -> float:
        self._place += self._way
        return self._place

    def end(self) -> None:
        pass


@pytest.mark.long
@pytest.mark.manual("PD-082", "PD-320")
def test_system_clock_is_exact_and_tells_250_us_apart() -> None:
    bench = Bench("belt", measuring_inputs={"M_1": "panel.m1"}).boot().run(2_000).enable("belt")
    axis = bench.axis("belt")
    bench.set("belt.ControllerEnable", True)
    axis.follow(_Steady(1_000))  # increments in a cycle of 4 ms: 62.5 in 250 us
    bench.run(500)
    latched: list[int] = []
    for quarter in range(8):
        bench.run(40 + 0.25).signal("panel.m1", 1).run(8).signal("panel.m1", 0).run(8)
        count = round((bench.rig.now_ns / MS - quarter) / 4)
        assert count
        latched.append(int(bench.get("M_1.Position_belt")) % 1_000)
    steps = [(after - before) % 1_000 for before, after in pairwise(latched)]
    assert steps == pytest.approx([62.5] * 7, abs=2), "each edge comes 250 us later in its cycle"
    begun, timer = bench.rig.now_ns, int(bench.get("Timer1"))
    bench.run(60_000)
    assert int(bench.get("Timer1")) - timer == pytest.approx((bench.rig.now_ns - begun) / MS, rel=1e-3)
    assert int(bench.get("Timer10")) == int(bench.get("Timer1")) // 10


@pytest.mark.long
@pytest.mark.manual("PD-086")
def test_there_is_no_watchdog() -> None:
    """A real-time process that takes ten cycles for each of its own is reported, and nothing resets the controller."""
    bench = Bench("belt").boot().run(500)
    bench.fault("max4", what="overrun", us=40_000)
    bench.run(10_000)
    assert bench.codes().count(8002) == 1
    assert bench.codes().count(8016) == 0
    assert (bench.get("DiagCode"), bench.get("ring.state")) == (6507, "up")
    assert int(bench.get("Timer1")) > 10_000


@pytest.mark.long
@pytest.mark.manual("PD-090")
def test_searching_from_leds_over_the_configuration_to_the_log() -> None:
    """Which unit, which axis, what and when: each step leads to the next."""
    with RingLab().boot() as lab:
        lab.fault("jaw", "overtemperature")
        lab.run(200)
        leds = {name: lab.get(f"led.{name}") for name in ("power", "err", "bus")}
        assert leds == {"power": "on", "err": "flashing", "bus": "on"}
        code, ext, _ = lab.diagnosis()
        place, _, repeated = str(ext).partition(" ")
        assert repeated == str(code)
        axis = next(name for name in lab.names if f"{lab.get(f'{name}.RealTimeBusAdr')}.1" == place)
        assert (axis, lab.get(f"{axis}.DiagCode"), lab.get(f"{axis}.DiagMsg")) == (
            "jaw",
            3117,
            "Motortemperatur zu hoch",
        )
        stamp, *rest = lab.log()[-1].split(" ")
        assert rest[:4] == ["0x0002", "MC_4", axis, str(code)]
        assert float(stamp.split(":")[-1]) > 0


# ---- the drive bus


class Times(Bench):
    """The telegrams on the ring of a controller with `drives` drives, with their times."""

    def __init__(self, drives: int, cycle_ms: int) -> None:
        self.answers: list[int] = []
        self.cycles: list[int] = []
        super().__init__(*[f"d{number}" for number in range(drives)], cycle_ms=cycle_ms)
        self.boot().run(1_500)
        self.answers.clear()
        self.cycles.clear()
        self.run(2_000)

    def _on_delivery(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if isinstance(delivery.message, Answers):
            self.answers.append(delivery.time_ns)
        elif isinstance(delivery.message, Cycle) and "d0" in delivery.receivers:
            self.cycles.append(delivery.time_ns)


@pytest.mark.long
@pytest.mark.manual("PD-131")
def test_telegrams_take_their_time_at_4_mbaud() -> None:
    """A second AT has 21 bytes: address, status, service channel, and S-0-0051, 40, 84, 182 and 390.  With 16 bits of
    FCS, a fifth more by stuffing at most, and two delimiters it has 236 bits; 10 us are between two telegrams.  A
    second record in the MDT has 14 bytes, 134 bits."""
    short, two = Times(1, 4), Times(2, 4)
    assert two.answers[0] % MS - short.answers[0] % MS == pytest.approx(236 * 250 + 10_000, abs=250)
    longer = (two.cycles[0] - two.answers[0]) - (short.cycles[0] - short.answers[0])
    assert longer == pytest.approx(134 * 250, abs=250)


@pytest.mark.long
@pytest.mark.manual("PD-139")
@pytest.mark.parametrize("cycle_ms", [1, 4])
def test_set_values_arrive_at_the_same_instant_of_each_cycle(cycle_ms: int) -> None:
    """Whatever else the ring carries: parameters are written and read meanwhile."""
    times = Times(2, cycle_ms)
    for number in range(20):
        times.set("d0.StopTimeLim", 900 + number).run(100)
    assert len(times.cycles) >= 1_000
    assert {after - before for before, after in pairwise(times.cycles)} == {cycle_ms * MS}
    assert times.cycles[-1] % (cycle_ms * MS) < cycle_ms * MS - 100 * US


# ---- limits and identity


@pytest.mark.manual("PD-314")
@pytest.mark.parametrize("version", [Version(0, 6), Version(0, 15)])
def test_markers_inputs_and_outputs_have_64_kbyte_each(version: Version) -> None:
    limits = limits_of(version)
    assert limits.area == 65_536
    assert limits.data - limits.variables == 3 * 65_536, "they are taken off the data area"


@pytest.mark.long
@pytest.mark.manual("PD-396")
def test_a_service_report_can_be_filled_in() -> None:
    """Controller, drive and motor say who they are; and what the form lists as causes can be seen."""
    identity = {"article_number": "13130241-003", "serial_number": "4711", "hardware_code": "02.10.00"}
    versions = {"article_number": "13130211-007", "serial_number": "0815", "hardware": "03.00.01"}
    bench = Bench("belt", identity=identity, version="V00.16.02", of_drives={"belt": {"versions": versions}})
    bench.boot().run(2_000)
    keys = ("ProductName", "ArticleNumber", "SerialNumber", "SoftwareVersion", "HardwareCode")
    assert [bench.get(key) for key in keys] == ["MAx-4", "13130241-003", "4711", "V00.16.02", "02.10.00"]
    keys = ("ControllerType", "ArticleNumber", "SerialNumber", "FirmwareVersion", "HardwareVersion")
    there = [bench.get(f"belt.{key}") for key in keys]
    assert there == ["MC-4/11/22/400", "13130211-007", "0815", "MC-4/11/22/400 V00.07.00", "V03.00.01"]
    assert (bench.get("belt.MotorType"), bench.get("belt.MotorSerialNumber")) == (
        "SM-100/30/080/P1/45/M0",
        "17130068-0001",
    )
    causes: list[tuple[str, dict[str, str], int]] = [("supply_24v", {}, 7134), ("wrong_motor", {}, 1117)]
    causes += [("encoder_signal", {}, 1105), ("overtemperature", {"of": "amplifier"}, 3193)]  # the ventilation
    for what, more, code in causes:
        number = bench.fault("belt", what=what, **more)
        bench.run(500)
        assert bench.get("belt.DiagCode") == code
        bench.heal("belt", number).run(500)
        bench.do("quit").run(2_000)
        assert bench.get("belt.DiagCode") == 0
