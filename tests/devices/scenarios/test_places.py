"""A condition may name, on the shipped rigs, points, objects, wires, messages, diagnoses and variables."""

from pathlib import Path

import pytest

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import load
from fieldrig.device import Value
from fieldrig.errors import RigError
from fieldrig.virtual.rig import Rig
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.diagnoses import diagnosis_keys, shows
from fieldrig_devices.scenarios.expression import expression_of
from fieldrig_devices.scenarios.play import Played, play
from fieldrig_devices.scenarios.property import Kind, Property

CONFIGS = Path(__file__).parents[3] / "configs"


def played(file: str, *acts: Act, condition: str, length_ns: int, boot_ns: int = 0) -> Played:
    """Play actions to a shipped rig, and return where the condition was ever true."""
    with Rig(load(CONFIGS / file, ("time=virtual",))) as rig:
        rig.run_until(boot_ns)
        return play(rig, acts, [Property("it", Kind.NEVER, expression_of(condition))], length_ns)


def first_ms(found: Played) -> float:
    [violation] = found.violations
    return violation.at_ns / MS


NODE = "message(can0, node=io, service=boot-up)"


@pytest.mark.parametrize(
    ("condition", "is_seen"),
    [
        ("message(can0, id=0x705)", True),
        ("message(can0, id=0x700-0x77F, data=00)", True),
        ("message(can0, id=0x705, data=01)", False),
        (NODE, True),
        ("message(can0, node=i*, service=heartbeat)", True),
        ("message(can0, node=5, text='*boot-up*')", True),
        ("message(can0, node=sensor, service=boot-up)", False),
        ("message(can0, sender=sensor)", True),
        ("message(can0, sender=s*r, service=boot-up)", False),
        ("message(can0, sender='a master')", False),
        ("message(can0, service=error)", False),
        ("count(can0, id=0x705) >= 2", True),
        ("count(can0, id=0x705) >= 3", False),
        ("since(can0, node=sensor) > 0.99", True),
        ("since(can0, node=sensor) > 1", False),
        ("message(can0, id=0x705) and count(can0, id=0x705) == 1", True),
        ("message(can0, id=0x705) and count(can0, id=0x705) == 0", False),  # it is counted when it arrives
        ("message(can0, node=sensor) and since(can0, node=sensor) > 0", False),
        ("io/1000:00 == 0xF0191", True),
        ("io/nmt.state == operational", False),
        ("io/nmt.state == pre_operational and contains(io/1008:00, 'IO')", True),
    ],
)
def test_messages_objects_and_states_of_a_node_that_starts_again(condition: str, is_seen: bool) -> None:
    restart = Act(100 * MS, "restart", "io")
    found = played("lab.yaml", restart, condition=condition, length_ns=1 * S, boot_ns=2 * S)
    assert bool(found.violations) is is_seen


def test_a_message_is_an_instant_before_what_it_causes() -> None:
    start = Act(100 * MS, "send", "can0", "000#0105")
    told = "message(can0, id=0) and io/nmt.state == pre_operational"
    found = played("lab.yaml", start, condition=told, length_ns=200 * MS, boot_ns=2 * S)
    assert 100 < first_ms(found) < 101
    done = played("lab.yaml", start, condition="io/nmt.state == operational", length_ns=200 * MS, boot_ns=2 * S)
    assert first_ms(done) == first_ms(found)


def test_an_emergency_has_its_code() -> None:
    hot = Act(100 * MS, "fault", "axis", {"what": "overtemperature"})
    for condition in ("message(can0, code=0x4310)", "message(can0, node=axis, service=emcy, data='10 43')"):
        assert 100 < first_ms(played("drive.yaml", hot, condition=condition, length_ns=1 * S, boot_ns=2 * S)) < 102
    other = played("drive.yaml", hot, condition="message(can0, code=0x8130)", length_ns=1 * S, boot_ns=2 * S)
    assert not other.violations


@pytest.mark.long
@pytest.mark.parametrize(
    ("file", "boot_s", "act", "condition"),
    [
        ("drive.yaml", 2, Act(0, "fault", "axis", {"what": "overtemperature"}), "diagnosis(axis, 0x4310)"),
        ("arp-cell.yaml", 5, Act(0, "restart", "line"), "diagnosis(line, 105)"),
    ],
)
def test_diagnoses_of_each_family(file: str, boot_s: int, act: Act, condition: str) -> None:
    assert played(file, act, condition=condition, length_ns=2 * S, boot_ns=boot_s * S).violations


@pytest.mark.parametrize(
    ("number", "value", "is_shown"),
    [
        ("3117", 3117, True),
        ("0xC2D", 3117, True),
        ("3117", 3118, False),
        ("311", "3117\n8003", False),
        ("8003", "3117\n8003", True),
        ("0680F010", "0680F010\n0780E013", True),
        ("0680f010", "0680F010", True),
        ("680", "0680F010", False),
        ("following_error", "over_voltage following_error", True),
        ("1", True, False),
        ("0", "", False),
    ],
)
def test_a_diagnosis_is_a_number_or_a_word_of_a_list(number: str, value: Value, is_shown: bool) -> None:
    assert shows(number)(value) is is_shown


def test_a_controller_shows_its_own_diagnoses_and_those_of_its_axes() -> None:
    config = load(CONFIGS / "conveyor.yaml", ("time=virtual",))
    known = ["DiagCode", "DiagMsg", "Infeed.DiagCode", "Cutter.DiagCode", "Cutter.AxisState", "plc/fault"]
    expected = ["DiagCode", "Infeed.DiagCode", "Cutter.DiagCode", "plc/fault"]
    assert diagnosis_keys(config, "max4", known) == expected


@pytest.mark.parametrize(
    ("condition", "what"),
    [
        ("message(can9, id=1)", "no bus 'can9'"),
        ("message(can0, id=99999999999)", "too large"),
        ("message(can0, id=1x1)", "no identifier"),
        ("message(can0, node=oi)", "no node 'oi'"),
        ("message(can0, service=heartbaet)", "did you mean heartbeat"),
        ("message(can0, code=zz)", "code"),
        ("message(can0, data=1)", "data"),
        ("message(mb_tcp, id=1)", "no identifiers"),
        ("message(mb_tcp, register=nothing)", "no register"),
        ("diagnosis(oi, 3)", "no device 'oi'"),
        ("diagnosis(tank, 3)", "shows no diagnoses"),
        ("wires/tnak.level > 3", "has no signal"),
        ("io/6041:00 == 3", "6041:00"),
    ],
)
def test_what_the_rig_does_not_have_is_refused(condition: str, what: str) -> None:
    with pytest.raises(RigError, match=what.replace("(", "\\(")):
        played("lab.yaml", condition=condition, length_ns=1 * MS)


@pytest.mark.long
def test_a_variable_that_no_point_shows_is_named_as_in_recordings() -> None:
    """A local variable of PLC_PRG is no point: the reset of the axis, which is over before the machine is hot."""
    name = "feeder/program:PLC_PRG.bResetting"
    found = played("feeder.yaml", condition=f"{name} and feeder/g_bHot", length_ns=2 * S)
    values = [value for _, value in found.tracks[name]]
    assert values[:2] == [True, False]
    with pytest.raises(RigError, match=r"has no value 'program:PLC_PRG\.bReseting'"):
        played("feeder.yaml", condition="feeder/program:PLC_PRG.bReseting", length_ns=1)
