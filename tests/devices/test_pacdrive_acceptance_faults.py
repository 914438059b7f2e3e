"""Every fault that `fieldrig fault` knows of, on the whole ring of configs/ring.yaml while its axes turn.

For each: what the axis and the controller say, what the log shows, that acknowledging it before its cause is gone
does not help, and that acknowledging it afterwards does.  Then the same bytes in one process and in many.
"""

import re
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest
from ring_lab import DRIVES, LINE, RING, RingLab

from fieldrig_bus.can.frame import CanFrame

pytestmark = pytest.mark.long

RPM = {"infeed": 300.0, "film": 300.0, "jaw": 150.0, "outfeed": 600.0}
CLEAR = (0, "", "")


class Case(NamedTuple):
    where: str
    what: str
    more: dict[str, Any]
    axis: str
    code: int
    text: str
    states: list[int]
    """MC4State on the way to a standstill."""


A, B, LOST, OVERLOAD = [0x42, 0x02], [0x40, 0x41, 0x02], [0x40, 0x41, 0x03], [0x30, 0x32]
CASES = [
    Case("film", "enable_lost", {}, "film", 0, "", LOST),
    Case("film", "overtemperature", {}, "film", 3117, "Motortemperatur zu hoch", B),
    Case("film", "overtemperature", {"of": "amplifier"}, "film", 3193, "Endstufentemperatur zu hoch", B),
    Case("film", "overload", {}, "film", 3125, "Überlast", OVERLOAD),
    Case("film", "dc_bus", {}, "film", 2106, "Kommunikationsfehler ZK-Controller", B),
    Case("film", "dc_bus", {"sort": "undervoltage"}, "film", 2194, "ZK-Unterspannung", B),
    Case("film", "dc_bus", {"sort": "overvoltage"}, "film", 1108, "ZK-Überspannung", A),
    Case("film", "dc_bus", {"sort": "phase"}, "film", 2195, "Netzphase fehlt", B),
    Case("film", "encoder_memory", {}, "film", 1117, "Lesefehler Geber-EEPROM", A),
    Case("film", "encoder_signal", {}, "film", 1105, "Gebersignal fehlt", A),
    Case("film", "wrong_motor", {}, "film", 1117, "Lesefehler Geber-EEPROM", A),
    Case("film", "supply_24v", {}, "film", 7134, "Externe 24V-Versorgung zu niedrig", []),
]


def speeding_up(rpm: float) -> Callable[[float], float]:
    """Increments by milliseconds: to `rpm` within a second."""
    per_ms = rpm / 60_000 * 1_000_000
    return lambda ms: per_ms * (ms * ms / 2_000 if ms < 1_000 else ms - 500)


def turning(lab: RingLab) -> RingLab:
    """All axes, at their speeds."""
    for name in DRIVES:
        lab.follow(name, speeding_up(RPM[name]))
    lab.run(1_300)
    for name in DRIVES:
        assert lab.speed(name) == pytest.approx(RPM[name], rel=0.02)
    return lab


def standing(lab: RingLab) -> bool:
    """Below n_min; without torque the small one hardly brakes itself."""
    return all(abs(lab.speed(name)) < 10 for name in DRIVES)


@pytest.fixture
def lab() -> Any:
    with RingLab() as lab:
        yield turning(lab.boot().enable())


def logged(lab: RingLab) -> list[str]:
    """Return the entries since the boot without their stamps, which other tests check."""
    return [re.sub(r"^\S+ ", "", line) for line in lab.log()[2:]]


@pytest.mark.manual("PD-091", "PD-093", "PD-097", "PD-098", "PD-100", "PD-118")
@pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join((case.what, *case.more.values())))
def test_fault_of_a_drive_is_shown_quitted_and_over(lab: RingLab, case: Case) -> None:
    number = lab.fault(case.where, case.what, **case.more)
    course = lab.course(case.axis, 1_200)
    states = list(dict.fromkeys(int(line[2]) for line in course))
    assert states == (case.states or [0x21])
    assert lab.get(f"{case.axis}.DiagCode") == case.code
    assert lab.get(f"{case.axis}.DiagMsg") == case.text
    if case.code:
        assert lab.diagnosis() == (case.code, f"2.1 {case.code}", f"MC_4.{case.axis} {case.text}")
        assert logged(lab) == [f"0x0002 MC_4 {case.axis} {case.code}  {case.text}"]
        assert lab.get("led.err") == "flashing"
    else:
        assert (lab.diagnosis(), logged(lab)) == (CLEAR, [])
    others = [name for name in DRIVES if name != case.axis]
    assert all(lab.speed(name) == pytest.approx(RPM[name], rel=0.02) for name in others), "the others go on"
    lab.do("quit").run(1_500)
    if case.code:
        assert lab.get(f"{case.axis}.DiagCode") == case.code, "its cause is still there"
    lab.heal(case.where, number).run(2_000)
    lab.do("quit").run(2_000)
    assert lab.diagnosis() == CLEAR
    assert all(lab.states(name) == (3, 0x21) for name in DRIVES), "ControllerEnable was never taken away"
    turning(lab)


@pytest.mark.manual("PD-161")
def test_brake_that_sticks_is_a_following_error_when_the_axis_moves() -> None:
    with RingLab("devices.jaw.amplifier.continuous_current_a=4.0").boot() as lab:  # 16 Nm against 24
        number = lab.fault("jaw", "stuck_brake")
        lab.enable().follow("jaw", speeding_up(300))
        lab.until(lambda: lab.get("jaw.DiagCode") != 0).run(1_500)
        assert lab.diagnosis() == (3196, "3.1 3196", "MC_4.jaw Schleppfehler zu groß")
        assert lab.states("film") == (3, 0x21)
        lab.heal("jaw", number).run(100)
        lab.do("quit").run(2_000)
        assert (lab.diagnosis(), lab.states("jaw")) == (CLEAR, (3, 0x21))


def test_brake_that_does_not_hold_lets_the_jaw_fall(lab: RingLab) -> None:
    lab.fault("jaw", "stuck_brake", stays="off")
    lab.disable("jaw").run(1_000)
    assert lab.states("jaw") == (1, 0x10)
    assert lab.speed("jaw") < -50, "20 Nm pull it down"


# ---- the ring


@pytest.mark.manual("PD-140")
@pytest.mark.parametrize("after", ["master", *DRIVES])
def test_ring_broken_anywhere_and_healed_while_axes_turn(lab: RingLab, after: str) -> None:
    """One entry says that it is open; drives behind the break, that they heard nothing; one, that it is up again."""
    cut = lab.fault("ring", "break", after=after)
    lab.run(1_500)
    assert logged(lab) == ["0x0002 MAX4 MAX4 2560  SERCOS-Ring offen"]
    assert lab.diagnosis() == (2560, "", "MAX4.MAX4 SERCOS-Ring offen")
    assert [lab.get(f"{name}.DiagCode") for name in DRIVES] == [2560] * 4
    assert (lab.get("ring.state"), lab.get("ring.phase"), lab.get("ring.open")) == ("down", 0, True)
    assert standing(lab)
    assert lab.of("jaw", "brake_on") is True
    lab.do("quit").run(500)
    assert lab.diagnosis()[0] == 2560
    lab.heal("ring", cut).run(500)
    assert lab.get("ring.state") == "down", "a user has to acknowledge"
    lab.do("quit").run(8_000)
    behind = DRIVES[(0, *(place + 1 for place in range(4)))[("master", *DRIVES).index(after)] :]
    assert logged(lab)[1:] == [
        *(f"0x0002 MC_4 {name} 2112  SERCOS-Ring gestört" for name in behind),
        "0x1000 MAX4 MAX4 8568  SERCOS-Ring in Betrieb",
    ]
    assert (lab.diagnosis(), lab.get("ring.state")) == (CLEAR, "up")
    assert not any(lab.get(f"{name}.ControllerEnable") for name in DRIVES), "nothing moves by itself"
    turning(lab.enable())


@pytest.mark.manual("PD-140")
def test_drive_without_power_opens_the_ring(lab: RingLab) -> None:
    off = lab.fault("ring", "off", station="film")
    lab.run(1_000)
    assert logged(lab) == ["0x0002 MAX4 MAX4 2560  SERCOS-Ring offen"]
    lab.heal("ring", off).run(100).do("quit").run(8_000)
    assert lab.diagnosis() == CLEAR
    turning(lab.enable())


@pytest.mark.parametrize(
    ("what", "more"), [("late", {"station": "film"}), ("distort", {"station": "film", "telegram": "at"})]
)
def test_answer_that_fails_once_is_forgiven_and_twice_brings_the_ring_down(
    lab: RingLab, what: str, more: dict[str, Any]
) -> None:
    lab.fault("ring", what, count=1, **more)
    lab.run(500)
    assert (lab.get("ring.state"), lab.get("film.ATErrors"), logged(lab)) == ("up", 1, [])
    assert lab.speed("film") == pytest.approx(RPM["film"], rel=0.02)
    lab.fault("ring", what, count=2, **more)
    lab.run(1_000)
    assert lab.get("ring.state") == "down"
    assert logged(lab) == ["0x0002 MC_4 film 2561  Antriebstelegramm fehlt"]
    assert lab.diagnosis() == (2561, "2.1 2561", "MC_4.film Antriebstelegramm fehlt")
    lab.do("quit").run(8_000)
    assert logged(lab)[1:] == ["0x1000 MAX4 MAX4 8568  SERCOS-Ring in Betrieb"]
    assert lab.diagnosis() == CLEAR
    turning(lab.enable())


def test_distorted_segment_takes_the_answers_from_before_it_and_the_commands_behind_it(lab: RingLab) -> None:
    distorted = lab.fault("ring", "distort", after="film")
    lab.run(1_000)
    assert lab.get("ring.state") == "down"
    assert {int(line.split(" ")[3]) for line in logged(lab)} <= {2561, 2560}
    assert standing(lab)
    lab.heal("ring", distorted).run(100).do("quit").run(8_000)
    assert lab.diagnosis() == CLEAR
    turning(lab.enable())


# ---- the controller


def test_controller_without_power_lets_the_drives_stop_by_themselves(lab: RingLab) -> None:
    lab.fault("max4", "power_off", duration_ms=2_000.0)
    lab.run(1_000)
    assert lab.get("power") is False
    assert [lab.of(name, "diag_code") for name in DRIVES] == [2112] * 4
    assert standing(lab)
    lab.run(1_100).boot()
    assert logged(lab) == [
        "0x0001 MAX4 MAX4 8002  Max4-Boot gestartet",
        *(f"0x0002 MC_4 {name} 2112  SERCOS-Ring gestört" for name in DRIVES),
        "0x0001 MAX4 MAX4 8003  Max4-Boot beendet",
    ]
    lab.do("quit").run(4_000)
    assert lab.diagnosis() == CLEAR
    turning(lab.enable())


def test_emergency_stop_takes_inverter_enable_from_all_drives(lab: RingLab) -> None:
    lab.rig.set("panel", "6200:01", 0)
    lab.run(1_000)
    assert [lab.states(name) for name in DRIVES] == [(0, 0x03)] * 4
    assert standing(lab)
    assert lab.diagnosis() == CLEAR, "no error: it is a mode of operation"
    lab.rig.set("panel", "6200:01", 1)
    lab.run(500)
    assert [lab.states(name) for name in DRIVES] == [(3, 0x21)] * 4


# ---- the same bytes


# SDO downloads to node 1: axis 1 in profile velocity, enabled, a turn a second
ORDERS = [
    "2f 60 60 00 03 00 00 00", "2b 40 60 00 06 00 00 00", "2b 40 60 00 07 00 00 00", "2b 40 60 00 0f 00 00 00",
    "23 ff 60 00 40 42 0f 00",
]  # fmt: skip


def played(lab: RingLab) -> list[str]:
    """Boot, enable, an axis moved over CAN, some faults, and every message on every bus."""
    lab.trace = []
    with lab:
        plc = lab.rig.attach("plc").link("can0")
        lab.run(3_000).enable("film", "jaw", "outfeed")
        for order in ORDERS:
            plc.send(CanFrame(0x601, bytes.fromhex(order)))
            lab.run(150)
        lab.run(1_000)
        assert lab.speed("infeed") == pytest.approx(60, rel=0.05)
        lab.fault("film", "dc_bus", start_ms=100.0, duration_ms=300.0)
        lab.fault("ring", "late", station="jaw", count=1, start_ms=50.0)
        lab.rig.set("outfeed", "load_torque", 0.5)
        lab.run(700).do("quit").run(500)
        cut = lab.fault("ring", "break", after="infeed")
        lab.run(200).heal("ring", cut).run(100).do("quit").run(1_500)
        lab.rig.set("panel", "6200:01", 0)
        lab.run(300)
        return lab.trace


def test_trace_is_the_same_in_one_process_and_in_many_and_over_two_runs() -> None:
    trace = played(RingLab(file=RING))
    assert len(trace) > 5_000
    assert played(RingLab(file=RING)) == trace
    assert played(RingLab("processes=each", file=RING)) == trace


def test_forty_drives_come_up_follow_and_stop() -> None:
    with RingLab(file=LINE).boot().enable() as lab:
        assert len(lab.names) == 40
        assert [lab.states(name)[0] for name in lab.names] == [3] * 40
        for name in lab.names:
            lab.follow(name, speeding_up(120))
        lab.run(1_500)
        assert all(lab.speed(name) == pytest.approx(120, rel=0.05) for name in lab.names)
        lab.rig.set("panel", "6200:01", 0b1101)  # rack 2 is taken out of Inverter Enable
        lab.run(800)
        rack = {name for name in lab.names if lab.states(name)[0] == 0}
        assert rack == set(lab.names[10:20])
        assert lab.diagnosis() == CLEAR
