"""The minimum acceptance set of the PacDrive digest (section 5) on the whole rig of configs/ring.yaml.

Items 1, 2, 3, 6, 7 and 12, and 11 as far as it needs no program.  Parts have tests of their own; here a MAx-4, its
ring, four MC-4 with motors, name plates and loads, and an encoder on a line of its own do it together.
"""

from collections.abc import Sequence
from itertools import pairwise

import pytest
from ring_lab import CONFIGS, LINE, RingLab

from fieldrig.config.rig_file import load
from fieldrig.device import Value
from fieldrig.errors import ConfigError, ControlError

pytestmark = pytest.mark.long

BOOT = ["1 0x0001 MAX4 MAX4 8002  Max4-Boot gestartet", "57 0x0001 MAX4 MAX4 8003  Max4-Boot beendet"]
BOOT_WITH_AUTOSTART = [
    "1 0x0001 MAX4 MAX4 8002  Max4-Boot gestartet",
    "92 0x0001 LZS LZS 8004  IEC-Programm gestartet",
    "92 0x0001 LZS LZS 8005  Automatischer Programmstart aktiv",
    "98 0x0001 MAX4 MAX4 8003  Max4-Boot beendet",
]
AUTOSTART = (
    "devices.max4.autostart=true",
    "devices.max4.program=programs/lamp.st",
    "devices.max4.outputs={O_bEquipmentOnIndicatorH1: ''}",
)


# ---- 1: boot


@pytest.mark.manual("PD-040", "PD-042")
def test_boot_without_autostart_is_two_lines() -> None:
    with RingLab().boot() as lab:
        assert lab.log() == BOOT
        assert (lab.get("ring.state"), lab.diagnosis()[0], lab.get("led.err")) == ("up", 0, "off")


@pytest.mark.manual("PD-040", "PD-041")
def test_boot_with_autostart_is_8004_and_8005_before_8003() -> None:
    with RingLab(*AUTOSTART).boot() as lab:
        assert lab.log() == BOOT_WITH_AUTOSTART


@pytest.mark.manual("PD-045", "PD-115")
def test_commanded_reboot_is_8016_and_stamps_begin_anew() -> None:
    with RingLab().boot() as lab:
        lab.do("system reset").boot()
        assert lab.codes() == [8002, 8003, 8016, 8002, 8003]
        assert lab.log()[2].endswith("0x1000 MAX4 MAX4 8016  System Reset")
        assert lab.log()[3:] == BOOT


@pytest.mark.manual("PD-040", "PD-124")
def test_what_drives_find_while_the_controller_boots_is_logged_at_14_ms() -> None:
    """The manual's second log: the DC circuit of one axis fails, and later the 24 V of another."""
    faults = ("devices.infeed.faults=[{what: dc_bus, duration_ms: 5000}]",)
    with RingLab(*AUTOSTART, *faults).boot() as lab:
        assert lab.log() == [
            BOOT_WITH_AUTOSTART[0],
            "14 0x0002 MC_4 infeed 2106  Kommunikationsfehler ZK-Controller",
            *BOOT_WITH_AUTOSTART[1:],
        ]
        lab.fault("film", "supply_24v")
        lab.run(100)
        assert lab.log()[-1].endswith("0x0002 MC_4 film 7134  Externe 24V-Versorgung zu niedrig")
        assert lab.diagnosis() == (2106, "1.1 2106", "MC_4.infeed Kommunikationsfehler ZK-Controller")


# ---- 2: message logger


@pytest.mark.manual("PD-110", "PD-111", "PD-114")
def test_logger_keeps_325_entries_and_loses_the_oldest() -> None:
    with RingLab().boot() as lab:
        for _ in range(162):
            lab.do("login").do("logout")
        assert lab.get("MsgEntries") == 325
        assert lab.codes()[:2] == [8003, 8007], "8002 is gone"
        lab.do("login")
        numbers = [int(line.split("\t")[0]) for line in str(lab.get("log")).splitlines()]
        assert numbers == list(range(325, 0, -1))
        assert lab.codes()[:2] == [8007, 8008]


@pytest.mark.manual("PD-116", "PD-117")
@pytest.mark.parametrize(
    ("mask", "codes"),
    [(0xFFFF, [8007, 2106, 8016]), (0xFFFE, [2106, 8016]), (0xFFFD, [8007, 8016]), (0xEFFF, [8007, 2106])],
)
def test_filter_leaves_classes_out_and_not_their_diagnosis(mask: int, codes: list[int]) -> None:
    with RingLab().boot() as lab:
        lab.set("MsgFilter", mask).do("login")
        lab.fault("film", "dc_bus")
        lab.run(100)
        assert lab.diagnosis()[0] == 2106
        lab.do("system reset")
        assert lab.codes()[2:] == codes


@pytest.mark.manual("PD-115")
def test_stamps_are_time_since_the_boot_without_leading_zeros() -> None:
    with RingLab("devices.max4.boot.clock_starts=power_on").boot() as lab:
        lab.run(9_540 - lab.rig.now_ns / 1e6).do("login")
        assert lab.log()[-1] == "9.540 0x0001 LZS LZS 8007  EPAS-4 Login"
        lab.run(82_123).do("logout")
        assert lab.log()[-1] == "1:31.663 0x0001 LZS LZS 8008  EPAS-4 Logout"


# ---- 3: diagnosis


@pytest.mark.manual("PD-091", "PD-092", "PD-093")
def test_only_a_higher_class_overwrites_on_controller_and_axis() -> None:
    with RingLab().boot() as lab:
        supply = lab.fault("film", "supply_24v")
        lab.run(100)
        assert lab.diagnosis() == (7134, "2.1 7134", "MC_4.film Externe 24V-Versorgung zu niedrig")
        heat = lab.fault("jaw", "overtemperature")
        lab.run(100)
        assert lab.diagnosis() == (3117, "3.1 3117", "MC_4.jaw Motortemperatur zu hoch")
        lab.fault("outfeed", "overtemperature")
        lab.run(100)
        assert lab.diagnosis()[1] == "3.1 3117", "of equal class: the first stays"
        lab.fault("outfeed", "dc_bus", duration_ms=100.0)
        lab.run(50)
        assert lab.diagnosis()[:2] == (2106, "4.1 2106")
        lab.fault("film", "supply_24v")
        lab.run(100)
        assert lab.diagnosis()[0] == 2106
        codes = [lab.get(f"{name}.DiagCode") for name in ("infeed", "film", "jaw", "outfeed")]
        assert codes == [0, 7134, 3117, 2106]
        assert lab.get("jaw.DiagMsg") == "Motortemperatur zu hoch"
        lab.heal("film", supply).heal("jaw", heat)


@pytest.mark.manual("PD-092", "PD-100")
def test_quitting_takes_what_has_no_cause_any_more() -> None:
    with RingLab().boot() as lab:
        lab.fault("film", "overtemperature", duration_ms=100.0)
        stays = lab.fault("jaw", "overtemperature")
        lab.run(2_000)
        assert lab.diagnosis()[1] == "2.1 3117", "nothing goes by itself"
        lab.do("quit").run(2_000)
        assert (lab.get("film.DiagCode"), lab.get("jaw.DiagCode")) == (0, 3117)
        assert lab.diagnosis()[:2] == (3117, "3.1 3117")
        assert lab.get("led.err") == "flashing"
        lab.heal("jaw", stays).do("quit").run(2_000)
        assert (lab.diagnosis(), lab.get("led.err")) == ((0, "", ""), "off")
        assert lab.codes().count(3117) == 2


# ---- 6: enabling, stopping, errors.  States and contacts as the drive has them, the axis object as the MAx-4 has it

CONTROLLED = (3, 0x21, True, True, True, 0)
"""AxisState, MC4State, brake relay, torque, ready contact, DiagCode."""
HEAVY = ("devices.jaw.load.inertia_kg_m2=6.0", "devices.jaw.load.torque_nm=0.0", "devices.jaw.motor.expected_type=null")
Course = Sequence[tuple[Value, ...]]


def seen(course: Course) -> list[tuple[Value, ...]]:
    return [line[1:] for line in course]


def between(course: Course, first: int, second: int) -> int:
    """Milliseconds between two changes."""
    return int(course[second][0]) - int(course[first][0])


@pytest.mark.manual("PD-150", "PD-163")
def test_10_1_switch_on_enable() -> None:
    with RingLab("devices.panel.objects={}").boot() as lab:
        assert lab.states("jaw") == (0, 0x03)
        lab.rig.set("panel", "6200:01", 1)
        lab.run(20)
        assert lab.states("jaw") == (1, 0x10)
        lab.set("jaw.ControllerEnable", True)
        course = lab.course("jaw", 200)
        assert seen(course) == [
            (1, 0x10, False, False, True, 0),
            (2, 0x20, True, True, True, 0),
            CONTROLLED,
        ]
        assert between(course, 1, 2) == 100
        assert lab.states("jaw") == (3, 0x21)
        assert abs(int(lab.of("jaw", "position"))) < 2_000, "its weight didn't pull it down"


@pytest.mark.manual("PD-151")
def test_10_2_1_lifted_enable_stops_in_time() -> None:
    with RingLab().boot().enable("infeed", "jaw") as lab:
        lab.turn("jaw", 300)
        lab.disable("jaw")
        course = lab.course("jaw", 600)
        assert seen(course) == [
            CONTROLLED,
            (4, 0x40, True, True, True, 0),
            (4, 0x41, False, True, True, 0),
            (1, 0x10, False, False, True, 0),
        ]
        assert between(course, 2, 3) in range(50, 54 + 1), "BrakeCouplingTime, in whole cycles"
        assert (lab.of("jaw", "brake_on"), lab.diagnosis()[0]) == (True, 0)
        assert lab.states("infeed") == (3, 0x21), "the others go on"


@pytest.mark.manual("PD-152")
def test_10_2_2_lifted_enable_passes_the_limit_and_is_still_stopped() -> None:
    with RingLab(*HEAVY, "devices.jaw.parameters.stop_time_limit_ms=200").boot().enable("jaw") as lab:
        lab.turn("jaw", 1_000, 3_000).disable("jaw")
        course = lab.course("jaw", 1_000)
        assert seen(course)[1:] == [
            (4, 0x40, True, True, True, 0),
            (4, 0x40, True, True, False, 2190),
            (4, 0x41, False, True, False, 2190),
            (5, 0x02, False, False, False, 2190),
        ]
        assert between(course, 1, 2) == 200
        assert 200 < between(course, 1, 3) < 400
        assert lab.diagnosis() == (2190, "3.1 2190", "MC_4.jaw Stoppzeitlimit überschritten")


@pytest.mark.manual("PD-153", "PD-161")
def test_10_2_3_lifted_enable_never_stops_in_time() -> None:
    with RingLab(*HEAVY, "devices.jaw.parameters.stop_time_limit_ms=100").boot().enable("jaw") as lab:
        lab.turn("jaw", 1_000, 3_000).disable("jaw")
        course = lab.course("jaw", 400)
        assert seen(course)[1:5] == [
            (4, 0x40, True, True, True, 0),
            (4, 0x40, True, True, False, 2190),
            (4, 0x41, False, True, False, 2190),
            (4, 0x42, False, False, False, 2190),
        ]
        assert [between(course, 1, place) for place in (2, 3)] == [100, 200]
        lab.run(3_000)
        assert lab.speed("jaw") == 0, "its holding brake has stopped it"
        assert lab.codes()[2:] == [2190], "no further message"


@pytest.mark.manual("PD-154")
def test_10_3_1_reaction_b_stops_in_time() -> None:
    with RingLab().boot().enable("jaw") as lab:
        lab.turn("jaw", 300)
        lab.fault("jaw", "overtemperature")
        course = lab.course("jaw", 600)
        assert seen(course) == [
            (4, 0x40, True, True, False, 3117),
            (4, 0x41, False, True, False, 3117),
            (5, 0x02, False, False, False, 3117),
        ]
        assert lab.values_of("jaw.ready")[-1] is False
        assert lab.of("panel", "6000:01") == 0b11011, "the panel sees its contact open, and that the err LED flashes"


@pytest.mark.manual("PD-155")
def test_10_3_2_reaction_b_passes_the_only_limit() -> None:
    with RingLab(*HEAVY, "devices.jaw.parameters.stop_time_limit_ms=100").boot().enable("jaw") as lab:
        lab.turn("jaw", 1_000, 3_000)
        lab.fault("jaw", "overtemperature")
        course = lab.course("jaw", 300)
        assert seen(course)[:3] == [
            (4, 0x40, True, True, False, 3117),
            (4, 0x41, False, True, False, 2190),
            (4, 0x42, False, False, False, 2190),
        ]
        assert int(course[1][0]) in range(97, 104), "one limit"
        assert lab.codes()[2:] == [3117, 2190]


@pytest.mark.manual("PD-156")
def test_10_4_reaction_a_frees_the_motor_until_it_is_quitted() -> None:
    with RingLab().boot().enable("jaw") as lab:
        lab.turn("jaw", 300)
        lab.fault("jaw", "encoder_signal", duration_ms=500.0)
        course = lab.course("jaw", 600)
        assert seen(course) == [(4, 0x42, False, False, False, 1105), (5, 0x02, False, False, False, 1105)]
        assert lab.states("jaw") == (5, 0x02)
        lab.do("quit").run(1_000)
        assert lab.states("jaw") == (3, 0x21), "ControllerEnable is still there"


@pytest.mark.manual("PD-157")
def test_10_4_reaction_a_with_the_option_for_the_brake() -> None:
    with RingLab("devices.film.motor.name_plate=plates/sm-140-30-200-brake.yaml").boot() as lab:
        lab.set("film.CoastOption", 4).enable("film").turn("film", 300)
        lab.fault("film", "encoder_signal")
        course = lab.course("film", 6_000)
        assert seen(course) == [
            (4, 0x42, True, False, False, 1105),
            (4, 0x42, False, False, False, 1105),
            (5, 0x02, False, False, False, 1105),
        ]
        assert between(course, 1, 2) in range(48, 56)


@pytest.mark.manual("PD-158")
@pytest.mark.parametrize("option", [1, 2])
def test_10_4_coasting_runs_the_course_of_reaction_a(option: int) -> None:
    with RingLab().boot() as lab:
        lab.set("film.CoastOption", option).run(500).enable("film").turn("film", 300)
        if option == 1:
            lab.disable("film")
        else:
            lab.fault("film", "dc_bus")
        course = lab.course("film", 200)
        states = [line[:4] for line in seen(course)]
        assert (4, 0x42, False, False) in states
        assert not any(line[1] == 0x40 for line in states), "it doesn't ramp down"


@pytest.mark.manual("PD-159")
def test_10_5_1_overload_stops_in_time_and_goes_on_when_quitted() -> None:
    with RingLab().boot().enable("film") as lab:
        lab.turn("film", 300)
        at = int(lab.of("film", "position"))
        lab.fault("film", "overload", duration_ms=100.0)
        course = lab.course("film", 900)
        assert seen(course) == [(4, 0x30, True, True, True, 3125), (4, 0x32, True, True, True, 3125)]
        assert int(course[1][0]) < 800
        cycle_way = 300 / 60 * 0.004 * 1_000_000  # it goes back to where it was at a cycle, not when it was read
        assert abs(int(lab.of("film", "position")) - at) < cycle_way + 2_000
        assert lab.states("film") == (4, 0x32)
        lab.do("quit").run(1_000)
        assert (lab.states("film"), lab.diagnosis()[0]) == ((3, 0x21), 0)


@pytest.mark.manual("PD-160")
def test_10_5_2_overload_that_takes_more_than_800_ms_is_reaction_b() -> None:
    with RingLab(*HEAVY).boot().enable("jaw") as lab:
        lab.turn("jaw", 2_500, 4_000)
        lab.fault("jaw", "overload", duration_ms=100.0)
        course = lab.course("jaw", 2_500)
        assert [line[1] for line in seen(course)][:3] == [0x30, 0x40, 0x41]
        assert int(course[1][0]) in range(797, 804)
        assert course[1][6] == 2191
        assert lab.codes()[2:] == [3125, 2191]


# ---- 7: name plate

PLATE_FAULTS = [
    ("jaw_encoder", {"what": "memory"}),
    ("jaw_encoder", {"what": "silent"}),
    ("jaw_encoder", {"what": "checksum"}),
    ("jaw_encoder", {"what": "wrong_plate", "type": "SM-100/30/080/P1/45/M0", "factor": 0.4}),
    ("jaw", {"what": "encoder_memory"}),
    ("jaw", {"what": "wrong_motor"}),
]


@pytest.mark.manual("PD-094", "PD-171", "PD-172")
@pytest.mark.parametrize(
    ("where", "fault"), PLATE_FAULTS, ids=lambda value: value if isinstance(value, str) else value["what"]
)
def test_faulty_name_plate_is_1117_and_the_drive_is_not_enabled(where: str, fault: dict[str, object]) -> None:
    """Missing, unreadable, wrong, swapped; the texts are the manual's screen, with the name of this axis."""
    faults = "[{" + ", ".join(f"{key}: {value}" for key, value in fault.items()) + "}]"
    with RingLab(*((f"devices.{where}.faults={faults}",) if where == "jaw" else ())) as lab:
        number = 1 if where == "jaw" else lab.rig.add_fault(where, fault)
        lab.boot().run(4_000)
        assert "MC_4 jaw 1117  Lesefehler Geber-EEPROM" in "\n".join(lab.log())
        assert lab.codes().count(1117) == 1
        assert lab.diagnosis() == (1117, "3.1 1117", "MC_4.jaw Lesefehler Geber-EEPROM")
        assert (lab.get("jaw.DiagCode"), lab.get("jaw.DiagMsg")) == (1117, "Lesefehler Geber-EEPROM")
        lab.enable()
        assert lab.states("jaw") == (5, 0x02)
        assert lab.states("film") == (3, 0x21)
        lab.do("quit").run(2_000)
        assert lab.diagnosis()[0] == 1117, "it is still wrong"
        lab.heal(where, number).run(200)
        lab.do("system reset").boot()
        lab.do("quit").run(4_000).do("quit").run(1_000)
        assert lab.diagnosis()[0] == 0


@pytest.mark.manual("PD-170")
def test_motor_that_was_exchanged_for_a_right_one_is_recognised() -> None:
    plate = ("devices.jaw_encoder.name_plate=plates/sm-100-30-080.yaml", "devices.jaw.motor.expected_type=null")
    with RingLab(*plate).boot() as lab:
        lab.run(3_000)
        assert (lab.get("jaw.MotorType"), lab.diagnosis()[0]) == ("SM-100/30/080/P1/45/M0", 0)
        assert float(lab.get("jaw.RatedTorque")) == pytest.approx(6.3, abs=0.1)


# ---- 11: the conveyor sample's motion, on a simulated MC-4 and on a real one


def straight_between_two_cams(ms: float) -> float:
    """Start cam, straight, stop cam: increments.  The cams take over at the speed of the straight."""
    speed, ramp_ms, run_ms = 5_000.0, 800.0, 1_000.0  # increments per ms: 300 1/min
    if ms < ramp_ms:
        x = ms / ramp_ms
        return speed * ramp_ms * (x**3 - x**4 / 2)  # its speed rises from 0 to 1 without a kink
    if ms < ramp_ms + run_ms:
        return speed * (ramp_ms / 2 + ms - ramp_ms)
    x = max(1 - (ms - ramp_ms - run_ms) / ramp_ms, 0.0)
    return speed * (ramp_ms + run_ms) - speed * ramp_ms * (x**3 - x**4 / 2)


@pytest.mark.manual("PD-030", "PD-182")
@pytest.mark.parametrize("simulated", [True, False])
def test_start_cam_straight_and_stop_cam_join_without_a_jump_of_speed(simulated: bool) -> None:
    word = str(simulated).lower()
    with RingLab(f"devices.infeed.simulated={word}").boot().enable("infeed") as lab:
        axis = lab.max4.firmware.axes["infeed"]
        lab.follow("infeed", straight_between_two_cams)
        speeds: list[float] = []
        before = axis.position
        for _ in range(720):
            lab.run(4)
            speeds.append((axis.position - before) / 4)
            before = axis.position
        assert max(speeds) == pytest.approx(5_000, rel=0.02)
        jumps = [abs(after - now) for now, after in pairwise(speeds)]
        assert max(jumps) < 5_000 * 4 / 800 * 1.5 * 1.3, "no more than the cams ask for"
        assert speeds[-1] == pytest.approx(0, abs=5)
        assert axis.position == pytest.approx(9_000_000, abs=200)
        assert lab.diagnosis()[0] == 0


@pytest.mark.manual("PD-022")
def test_lamp_output_reaches_its_wire() -> None:
    with RingLab().boot() as lab:
        for is_on in (True, False, True):
            lab.set("O_bLampH1.Value", is_on).run(600)
        assert lab.values_of("panel.h1") == [False, True, False, True]


# ---- 12: limits and versions


@pytest.mark.manual("PD-319")
def test_forty_axes_at_1_ms_do_not_fit_and_that_is_reported() -> None:
    with RingLab("devices.max4.cycle_ms=1", file=LINE).boot() as lab:
        code, ext, message = lab.diagnosis()
        assert (code, message) == (2564, "MAX4.MAX4 Zykluszeit zu kurz für alle Antriebe")
        assert str(ext).endswith(" us")
        assert lab.get("ring.state") == "down"


@pytest.mark.manual("PD-319")
@pytest.mark.parametrize(("ms", "right"), [(1, True), (2, True), (3, False), (4, True), (8, False)])
def test_other_cycles_than_1_2_and_4_ms_are_refused(ms: int, right: bool) -> None:
    overrides = [f"devices.max4.cycle_ms={ms}"]
    if right:
        assert load(CONFIGS / "ring.yaml", [*overrides, "time=virtual"])
        return
    with pytest.raises(ConfigError, match="1 or 2 or 4"):
        load(CONFIGS / "ring.yaml", [*overrides, "time=virtual"])


def test_more_drives_than_the_ring_may_have_are_refused() -> None:
    with pytest.raises(ConfigError, match="47"):
        load(CONFIGS / "ring.yaml", ["devices.max4.max_axes=48"])
    with pytest.raises(ConfigError, match=r"at most 39 \(max_axes\)"):
        load(LINE, ["devices.max4.max_axes=39"])


@pytest.mark.manual("PD-134")
def test_process_that_needs_more_than_its_cycle_is_a_write_overflow() -> None:
    with RingLab().boot() as lab:
        lab.fault("max4", "overrun", us=4_000, duration_ms=100.0)
        lab.run(200)
        assert lab.diagnosis()[0] == 6507
        assert lab.codes()[2:] == [6507]


@pytest.mark.manual("PD-046")
def test_disk_that_is_full_refuses_a_log_file() -> None:
    with RingLab("devices.max4.disk_bytes=65536").boot() as lab:
        for _ in range(300):
            lab.do("login")

        def fill() -> None:
            for number in range(20):
                lab.do(f"save log \\L{number}.LOG")

        with pytest.raises(ControlError, match="the flash disk is full"):
            fill()
        assert 0 <= int(lab.get("Diskfree")) < 30_000


VERSIONS = [
    ("V00.15.00", "00.15.00", True),
    ("V00.15.00", "00.14.99", True),
    ("V00.15.00", "00.15.99", True),
    ("V00.15.99", "00.16.00", False),
    ("V00.15.00", "01.00.00", False),
    ("V01.00.00", "00.15.00", False),
]


@pytest.mark.manual("PD-332")
@pytest.mark.parametrize(("controller", "drive", "fits"), VERSIONS)
def test_drive_of_another_version_is_refused_and_the_others_run(controller: str, drive: str, fits: bool) -> None:
    overrides = [f"devices.max4.version={controller}", f"devices.film.versions.firmware={drive}"]
    others = ".".join((controller[1:3], "00", "00"))
    overrides += [f"devices.{name}.versions.firmware={others}" for name in ("infeed", "jaw", "outfeed")]
    with RingLab(*overrides).boot().enable() as lab:
        assert (lab.states("film")[0] == 3) is fits
        assert lab.diagnosis()[:2] == ((0, "") if fits else (2565, "2.1 2565"))
        assert [lab.states(name)[0] for name in ("infeed", "jaw", "outfeed")] == [3, 3, 3]


@pytest.mark.manual("PD-331")
@pytest.mark.parametrize(
    ("tool", "fits"), [("V00.15.00", True), ("V00.16.00", True), ("V00.14.99", False), ("V01.15.00", False)]
)
def test_tool_of_another_version_is_refused(tool: str, fits: bool) -> None:
    with RingLab().boot() as lab:
        if fits:
            lab.do(f"login {tool}")
            assert lab.codes()[-1] == 8007
        else:
            with pytest.raises(ControlError, match="expected a version of EPAS-4 with the XX of"):
                lab.do(f"login {tool}")
            assert lab.codes()[-1] == 8003
