"""Diagnosis parameters of controller and axes: what is shown, what overwrites it, what quits it."""

from pathlib import Path

import pytest
from max4_bench import Bench

from fieldrig_devices.max4.messages.catalogue import MESSAGES, Code
from fieldrig_devices.max4.messages.diagnosis import LZS, MAX4, Diagnosis, Pending


def pending(code: int, *, is_quittable: bool = True) -> Pending:
    return Pending(code, f"ext {code}", f"msg {code}", is_quittable)


@pytest.fixture
def diagnosis() -> Diagnosis:
    return Diagnosis(lambda: None)


# what was shown, what comes, what is shown then (manual 4180)
OVERWRITES = [
    ((), 3117, 3117),
    ((3117,), 1117, 1117),
    ((3117,), 3125, 3117),
    ((3125,), 3117, 3125),
    ((3117,), 7134, 3117),
    ((1117,), 2106, 1117),
    ((7134, 3117), 2106, 2106),
    ((2106, 1117), 3117, 1117),
]


@pytest.mark.manual("PD-091")
@pytest.mark.manual("PD-092")
@pytest.mark.manual("PD-097")
@pytest.mark.parametrize(("before", "comes", "shown"), OVERWRITES)
def test_only_a_higher_class_overwrites(diagnosis: Diagnosis, before: tuple[int, ...], comes: int, shown: int) -> None:
    for code in (*before, comes):
        diagnosis.add(pending(code))
    assert (diagnosis.code, diagnosis.ext, diagnosis.msg) == (shown, f"ext {shown}", f"msg {shown}")


@pytest.mark.manual("PD-092")
@pytest.mark.manual("PD-100")
def test_quitting_takes_what_is_quittable_and_shows_the_rest(diagnosis: Diagnosis) -> None:
    diagnosis.add(pending(4313, is_quittable=False))
    diagnosis.add(pending(1117))
    diagnosis.quit()
    assert diagnosis.code == 4313
    diagnosis.quit()
    assert diagnosis.code == 4313
    diagnosis.withdraw(4313)
    assert (diagnosis.code, diagnosis.ext, diagnosis.msg) == (0, "", "")


@pytest.mark.manual("PD-100")
@pytest.mark.parametrize(("code", "is_quittable"), [(Code.CYCLE_ERROR, True), (Code.SERIOUS_CYCLE_ERROR, False)])
def test_cycle_errors_are_quittable_as_the_table_says(code: Code, is_quittable: bool) -> None:
    bench = Bench().run(100)
    bench.max4.firmware.report(code, LZS, "12/10")
    assert (bench.get("DiagCode"), bench.get("DiagExtCode")) == (code, "12/10")
    bench.set("DiagQuit", True)
    assert (bench.get("DiagCode") == 0) is is_quittable


@pytest.mark.manual("PD-097")
@pytest.mark.manual("PD-098")
def test_the_class_of_a_code_can_be_changed() -> None:
    bench = Bench(diagnosis_classes={6317: 3, 7567: 8, 8007: 1}).run(100)
    bench.max4.firmware.report(Code.RAM_LOST, MAX4)
    assert bench.get("DiagCode") == 0
    assert bench.codes()[-1] == 8567
    bench.max4.firmware.report(Code.CYCLE_ERROR, LZS, "12/10")
    assert bench.get("DiagCode") == 3317
    bench.do("login")
    assert bench.get("DiagCode") == 1007


@pytest.mark.manual("PD-047")
@pytest.mark.manual("PD-096")
def test_diagnosis_parameters_stand_in_the_order_of_the_screen() -> None:
    bench = Bench().run(100)
    names = [parameter.name for parameter in bench.max4.firmware.tree.root.groups["Diagnosis"].parameters.values()]
    assert names[:11] == [
        "DiagCode",
        "DiagExtCode",
        "DiagMsg",
        "MsgEntries",
        "Timer1",
        "Timer10",
        "CycleLoad",
        "RTBReadRes",
        "RTBWriteRes",
        "Diskfree",
        "Memoryfree",
    ]
    assert bench.get("Memoryfree") == 6_930_636


@pytest.mark.manual("PD-096")
def test_diagnosis_parameters_have_the_units_and_values_of_the_screen() -> None:
    """4165-4176: 108178 ms, 10817 x 10 ms, 14 %, 754 and 802 us, 3988992 and 6930636 bytes."""
    bench = Bench().run(100).clock_shows(108_178)
    units = ["", "ms", "10ms", "%", "us", "us", "Byte", "Byte"]
    points = bench.max4.points()
    names = ["MsgEntries", "Timer1", "Timer10", "CycleLoad", "RTBReadRes", "RTBWriteRes", "Diskfree", "Memoryfree"]
    assert [points[name].unit for name in names] == units
    entries, timer_1, timer_10, load, read_us, write_us, disk, memory = (int(bench.get(name)) for name in names)
    assert entries == len(bench.log())
    assert (timer_1, timer_10, memory) == (108_178, 10_817, 6_930_636)
    assert load == 100 * (read_us - write_us) // 4_000  # what lies between the two is the work of the cycle
    assert load > 0
    assert 0 < write_us < read_us < 4_000  # the writing comes after the reading, in a cycle of 4 ms
    assert 3_988_992 <= disk < 4_000_000


@pytest.mark.manual("PD-083")
def test_timers_count_from_the_start() -> None:
    bench = Bench().run(100).clock_shows(108_178)
    assert (bench.get("Timer1"), bench.get("Timer10")) == (108_178, 10_817)


@pytest.mark.manual("PD-099")
def test_err_led_flashes_while_a_diagnosis_is_pending() -> None:
    bench = Bench(err_wire="panel.err").run(100)
    assert bench.get("led.err") == "off"
    bench.max4.firmware.report(Code.DIVISION_ERROR, LZS)
    assert bench.get("led.err") == "flashing"
    assert bench.get("DiagMsg") == "LZS.LZS Divisionsfehler"
    bench.do("quit").run(1)
    assert bench.get("led.err") == "off"
    assert [value for _, name, value in bench.wires if name == "panel.err"] == [True, False]


@pytest.mark.long
@pytest.mark.manual("PD-093")
@pytest.mark.manual("PD-094")
@pytest.mark.manual("PD-172")
def test_unreadable_name_plate_shows_as_on_the_screen() -> None:
    """Acceptance 7."""
    bench = Bench("Servo1", addresses={"Servo1": 3}, of_drives={"Servo1": {"faults": [{"what": "encoder_memory"}]}})
    bench.boot().run(3_000)
    assert bench.get("DiagCode") == 1117
    assert bench.get("DiagExtCode") == "3.1 1117"
    assert bench.get("DiagMsg") == "MC_4.Servo1 Lesefehler Geber-EEPROM"
    assert (bench.get("Servo1.DiagCode"), bench.get("Servo1.DiagMsg")) == (1117, "Lesefehler Geber-EEPROM")
    logged = next(line for line in bench.log() if "1117" in line)
    assert logged.split("\t")[2:] == ["0x0002", "MC_4", "Servo1", "1117", "", "Lesefehler Geber-EEPROM"]
    bench.enable("Servo1").run(500)
    assert bench.get("Servo1.AxisState") not in (2, 3)
    bench.do("quit").run(500)
    assert bench.get("DiagCode") == 1117, "the cause is still there"


@pytest.mark.manual("PD-095")
@pytest.mark.manual("PD-093")
def test_english_messages_are_as_in_the_prose() -> None:
    bench = Bench("axis1", language="en").boot()
    bench.fault("axis1", what="overtemperature", duration_ms=50)
    bench.run(30)
    assert (bench.get("DiagCode"), bench.get("DiagExtCode")) == (3117, "1.1 3117")
    assert bench.get("DiagMsg") == "MC-4/axis1: motor temperature too high"
    assert bench.get("axis1.DiagMsg") == "motor temperature too high"
    bench.run(100)
    assert bench.get("DiagCode") == 3117, "only an acknowledgement resets it"
    bench.set("axis1.DiagQuit", True).run(500)
    assert (bench.get("DiagCode"), bench.get("axis1.DiagCode")) == (0, 0)


@pytest.mark.long
@pytest.mark.manual("PD-092")
def test_two_axes_have_their_own_and_the_controller_the_first_of_the_worst() -> None:
    bench = Bench("belt", "knife").boot()
    heat = bench.fault("belt", what="overtemperature")
    bench.run(30)
    bench.fault("knife", what="overtemperature")
    bench.run(30)
    assert (bench.get("belt.DiagCode"), bench.get("knife.DiagCode")) == (3117, 3117)
    assert bench.get("DiagExtCode") == "1.1 3117"
    bench.heal("belt", heat).set("belt.DiagQuit", True).run(1_000)
    assert (bench.get("belt.DiagCode"), bench.get("DiagExtCode")) == (0, "2.1 3117")


CATALOGUE = {
    4313: "Schwere", 6317: "Zykluszeit", 1117: "Lesefehler Geber-EEPROM", 2106: "Kommunikationsfehler ZK-Controller",
    7134: "Externe 24V-Versorgung zu niedrig", 8002: "Max4-Boot gestartet", 8003: "Max4-Boot beendet",
    8004: "IEC-Programm gestartet", 8005: "Automatischer Programmstart aktiv", 8007: "EPAS-4 Login",
    8008: "EPAS-4 Logout", 8010: "Datei schreiben", 8013: "connect zum TCP/IP Server", 8016: "System Reset",
}  # fmt: skip


@pytest.mark.manual("PD-098")
@pytest.mark.parametrize(("code", "text"), CATALOGUE.items())
def test_catalogue_has_the_codes_of_the_manual(code: int, text: str) -> None:
    assert MESSAGES[code].de.startswith(text)


def test_every_message_has_both_languages() -> None:
    assert all(message.de and message.en for message in MESSAGES.values())


@pytest.mark.long
@pytest.mark.manual("PD-090", "PD-099")
def test_leds_tell_power_error_program_and_bus(tmp_path: Path) -> None:
    program = tmp_path / "line.prg"
    program.write_bytes(b"PROGRAM PLC_PRG\nEND_PROGRAM")
    bench = Bench("belt", program=str(program))

    def leds() -> str:
        return " ".join(str(bench.get(f"led.{name}")) for name in ("power", "err", "run", "bus"))

    bench.run(50)
    assert leds() == "on off off flashing", "the ring comes up"
    bench.boot().run(2_000)
    assert leds() == "on off off on"
    bench.do("start")
    assert leds() == "on off on on"
    number = bench.fault("belt", what="overtemperature", duration_ms=100)
    bench.run(300)
    assert leds() == "on flashing on on"
    bench.do("quit").run(1_000)
    assert leds() == "on off on on"
    number = bench.fault("ring0", what="break", after="master")
    bench.run(300)
    assert leds() == "on flashing on off"
    bench.heal("ring0", number).do("stop")
    assert leds() == "on flashing off off"
    bench.fault("max4", what="power_off")
    assert leds() == "off off off off"


@pytest.mark.long
@pytest.mark.manual("PD-092", "PD-110")
def test_what_was_only_covered_by_something_worse_is_no_new_entry() -> None:
    """A drive shows its most severe code; after its acknowledgement the earlier code, still pending, is shown again."""
    bench = Bench("belt").boot().run(2_000)
    bench.fault("belt", what="supply_24v")
    bench.run(100)
    bench.fault("belt", what="overtemperature", duration_ms=100)
    bench.run(500)
    assert bench.get("DiagCode") == 3117
    bench.do("quit").run(2_000)
    assert (bench.get("belt.DiagCode"), bench.get("DiagCode")) == (7134, 7134)
    assert bench.codes()[-2:] == [7134, 3117]
    bench.fault("belt", what="overtemperature", duration_ms=100)
    bench.run(500)
    assert bench.codes()[-3:] == [7134, 3117, 3117], "this one is new"
