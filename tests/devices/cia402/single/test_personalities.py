"""Each difference of the personalities, alone and in its file, by the bytes and words of the manuals and reports.

Source: the table of differences in docs/devices/drive-personalities.md; CiA 402-2 for the words, CiA 301 for the
frames.
"""

from pathlib import Path
from typing import Any, get_args

import pytest
from canopen_bench import parse
from single_drive_bench import SingleDriveBench

from fieldrig_devices.cia402 import EDS
from fieldrig_devices.cia402.single.personality import FOLDER, Name, PersonalitySettings, rows_of

pytestmark = pytest.mark.long

NAMES = get_args(Name)
PP, VL, PV, HM, IP, CSP = 1, 2, 3, 6, 7, 8
TURN = 1_000_000
DISABLED, READY, ON, ENABLED, QUICK, FAULT = 0x40, 0x21, 0x23, 0x27, 0x07, 0x08
STATE = 0x6F
INVALID, READ_ONLY, NO_OBJECT, DEVICE_STATE = "06090030", "06010002", "06020000", "08000022"
QUICK_ANSWERS = {"boot_up_ms": 0, "sdo_answer_ms": 0, "sdo_answer_most_ms": 0, "loses_first_sdo": False}
ASK_1000H, ANSWER_TO_1000H = "605#40 00 10 00 00 00 00 00", "585#43 00 10 00 92 01 02 00"


def drive(**behaviour: Any) -> SingleDriveBench:
    return SingleDriveBench(behaviour=behaviour)


def state(bench: SingleDriveBench) -> int:
    """The state of the status word, in which bit 5 means nothing without power."""
    word: int = bench.drive.axis.status_word
    return word & (0x4F if word & 0x48 else STATE)


def steps(bench: SingleDriveBench, *words: int, ms: float = 2) -> int:
    for word in words:
        bench.control(word).after(ms)
    return state(bench)


# ---- the files


def test_every_name_has_its_file_and_every_file_its_name() -> None:
    assert {path.stem for path in FOLDER.iterdir()} == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_personality_is_what_its_file_says_and_single_keys_replace_it(name: str) -> None:
    settings = SingleDriveBench(personality=name).drive._settings
    assert settings.manner == PersonalitySettings.model_validate(rows_of(name))
    one = SingleDriveBench(personality=name, behaviour={"sdo_answer_ms": 7.0}).drive._settings
    assert one.manner.model_dump() == {**settings.manner.model_dump(), "sdo_answer_ms": 7.0}


@pytest.mark.parametrize("name", NAMES)
def test_a_drive_with_any_personality_boots(name: str) -> None:
    bench = SingleDriveBench(personality=name)
    bench.after(7_000)
    bench.send("605#40 41 60 00 00 00 00 00")
    bench.can.deliver(parse("605#40 41 60 00 00 00 00 00"))
    assert any(frame.startswith("585#4b 41 60 00") for frame in bench.after(200))


# ---- state machine


def test_0f_from_ready_switches_on_only() -> None:
    bench = drive(passes_switched_on=False)
    assert steps(bench, 0x06, 0x0F) == ON
    assert steps(bench, 0x0F) == ENABLED
    assert steps(drive(), 0x06, 0x0F) == ENABLED


def test_a_slow_loop_misses_words_that_are_replaced() -> None:
    bench = drive(control_cycle_ms=10)
    bench.control(0x06).control(0x07).control(0x0F).after(10)
    assert state(bench) == DISABLED
    assert steps(bench, 0x06, 0x07, 0x0F, ms=11) == ENABLED


def fail(bench: SingleDriveBench) -> None:
    """Have an error whose cause has gone again."""
    bench.drive.clear_fault(bench.drive.add_fault({"what": "error"}))
    bench.after(5)
    assert state(bench) == FAULT


def test_a_slow_loop_misses_a_short_reset() -> None:
    bench = drive(control_cycle_ms=10)
    fail(bench)
    bench.control(0x80).control(0x00).after(11)
    assert state(bench) == FAULT
    assert steps(bench, 0x80, ms=11) == DISABLED


def test_bit_7_resets_as_a_level() -> None:
    bench = drive(fault_reset="level").control(0x80)
    bench.drive.clear_fault(bench.drive.add_fault({"what": "error"}))
    bench.after(5)
    assert state(bench) == DISABLED
    by_edge = SingleDriveBench().control(0x80)
    fail(by_edge)
    assert steps(by_edge, 0x80) == FAULT


def test_a_reset_counts_twice_or_after_its_time() -> None:
    twice = drive(resets=2)
    fail(twice)
    assert steps(twice, 0x80, 0x00) == FAULT
    assert steps(twice, 0x80) == DISABLED
    locked = drive(reset_lock_ms=15_000)
    fail(locked)
    assert steps(locked, 0x80, 0x00) == FAULT
    locked.after(14_900)
    assert steps(locked, 0x80, 0x00) == FAULT
    locked.after(100)
    assert steps(locked, 0x80) == DISABLED


@pytest.mark.parametrize(("resumes", "after"), [(True, ENABLED), (False, QUICK)])
def test_0f_in_the_ramp_of_a_quick_stop(resumes: bool, after: int) -> None:
    bench = drive(quick_stop_resumes=resumes).put(0x605A, 2).put(0x6085, 10 * TURN)
    bench.enabled(PV).put(0x60FF, 10 * TURN).after(1_500)
    assert steps(bench, 0x02) == QUICK
    assert steps(bench, 0x0F) == after


def test_605a_6_stays_in_quick_stop_active() -> None:
    bench = SingleDriveBench(personality="step-by-step", behaviour={"boot_up_ms": 0, "sdo_answer_ms": 0})
    assert bench.get(0x605A) == 6
    assert steps(bench.put(0x6060, PV), 0x06, 0x07, 0x0F) == ENABLED
    assert steps(bench, 0x02, ms=500) == QUICK


# ---- power


def test_without_mains_it_stays_in_switch_on_disabled() -> None:
    bench = drive(needs_mains=True, mains_ms=3_000)
    assert steps(bench, 0x06) == READY
    bench.write_point("mains", False)
    bench.after(2_900)
    assert state(bench) == READY
    bench.after(200)
    assert state(bench) == DISABLED
    assert steps(bench, 0x00, 0x06) == DISABLED
    bench.write_point("mains", True)
    bench.after(2)
    assert state(bench) == READY  # the command is in force
    by_the_book = SingleDriveBench()
    by_the_book.write_point("mains", False)
    assert steps(by_the_book, 0x06) == READY


def test_without_sto_it_stays_in_switch_on_disabled_or_has_a_fault() -> None:
    gate = SingleDriveBench(sto=False, behaviour={"needs_sto": True})
    assert steps(gate, 0x06) == DISABLED
    assert steps(gate.wire("axis.sto", True), 0x06) == READY
    fault = SingleDriveBench(sto=False, behaviour={"sto_faults": True})
    fault.after(5)
    assert (state(fault), fault.get(0x603F)) == (FAULT, 0x9000)
    assert steps(fault, 0x80, 0x00) == FAULT
    assert steps(fault.wire("axis.sto", True), 0x80) == DISABLED


# ---- bits


@pytest.mark.parametrize(
    ("meaning", "at_rest", "without_sto", "enabled"),
    [("ready", 0x10, 0, 0x10), ("dc_link", 0x10, 0x10, 0x10), ("enabled", 0, 0, 0x10)],
)
def test_bit_4(meaning: str, at_rest: int, without_sto: int, enabled: int) -> None:
    bench = drive(voltage_bit=meaning)
    assert bench.status(0x10) == at_rest
    assert bench.wire("axis.sto", False).status(0x10) == without_sto
    assert bench.wire("axis.sto", True).enabled(PP).status(0x10) == enabled


def test_bit_9() -> None:
    assert (drive(remote_bit=False).status(0x200), SingleDriveBench().status(0x200)) == (0, 0x200)


def test_bits_14_and_15() -> None:
    bench = drive(bit_14="backwards", bit_15="standstill").enabled(PV)
    assert bench.status(0xC000) == 0x8000
    bench.put(0x60FF, -TURN).after(500)
    assert bench.status(0xC000) == 0x4000
    homed = drive(bit_14="warning", bit_15="homed")
    homed.put(0x6098, 37).enabled(HM).control(0x1F).after(20)
    homed.drive.add_fault({"what": "warning"})
    homed.after(5)
    assert homed.status(0xC000) == 0xC000


# ---- modes


def test_a_mode_waits_for_the_end_of_halt() -> None:
    bench = drive(changes_mode_in_halt=False).enabled(PP).control(0x10F).put(0x6060, PV)
    assert bench.get(0x6061) == PP
    assert bench.control(0x0F).get(0x6061) == PV
    assert SingleDriveBench().enabled(PP).control(0x10F).put(0x6060, PV).get(0x6061) == PV


def test_6061_follows_after_enabling_or_late() -> None:
    bench = drive(mode_display="enabled").put(0x6060, PV)
    bench.after(500)
    assert bench.get(0x6061) == 0
    steps(bench, 0x06, 0x07, 0x0F)
    assert bench.get(0x6061) == PV
    late = drive(mode_display_ms=200).put(0x6060, PV)
    late.after(199)
    assert late.get(0x6061) == 0
    late.after(2)
    assert late.get(0x6061) == PV


def test_mode_0() -> None:
    assert drive(mode_zero="refused").try_put(0x6060, 0) == INVALID
    bench = drive(mode_zero="not_enabled").put(0x6060, 0)
    assert steps(bench, 0x06, 0x07, 0x0F) == ON
    assert steps(bench.put(0x6060, PP), 0x0F) == ENABLED
    assert steps(SingleDriveBench(), 0x06, 0x07, 0x0F) == ENABLED


@pytest.mark.parametrize("name", NAMES)
def test_a_personality_has_its_modes_and_no_other(name: str) -> None:
    modes = set(rows_of(name)["modes"])
    bench = SingleDriveBench(personality=name, behaviour=QUICK_ANSWERS)
    taken = {mode for mode in range(-4, 11) if mode and bench.try_put(0x6060, mode) == ""}
    assert taken == modes
    bits = None if name == "late-and-thin" else sum(1 << (mode - 1) for mode in modes if mode > 0)
    assert bench.try_get(0x6502) == bits


# ---- profile position


def test_a_single_set_point_ignores_bit_4_during_a_move() -> None:
    """Technosoft: bit 12 stays set, and a set-point in that time is lost."""
    bench = drive(set_points=1).enabled(PP).put(0x607A, TURN).control(0x1F).control(0x0F)
    assert bench.status(0x1000) == 0x1000
    bench.put(0x607A, 3 * TURN).control(0x3F).control(0x0F)
    bench.until(lambda: bench.drive.axis.status_word & 0x1400 == 0x0400)
    bench.after(3_000)
    assert bench.read("position") == pytest.approx(6.2832, abs=0.01)


def test_three_set_points_wait_for_each_other() -> None:
    bench = drive(set_points=3).enabled(PP)
    for turns in (1, 2, 3):
        bench.put(0x607A, turns * TURN).control(0x1F).control(0x0F)
    assert bench.status(0x1000) == 0x1000
    bench.until(lambda: bench.drive.axis.status_word & 0x1400 == 0x0400)
    assert bench.read("position") == pytest.approx(3 * 6.2832, abs=0.01)


def test_bit_12_is_set_after_enabling() -> None:
    bench = drive(acknowledges_at_start=True).enabled(PP)
    assert bench.status(0x1000) == 0x1000
    assert bench.control(0x1F).control(0x0F).status(0x1000) == 0


def test_bit_12_comes_late() -> None:
    bench = drive(acknowledge_ms=50).enabled(PP).put(0x607A, 50 * TURN).control(0x1F)
    bench.after(48)
    assert bench.status(0x1000) == 0
    bench.after(4)
    assert bench.status(0x1000) == 0x1000
    assert bench.control(0x0F).status(0x1000) == 0


# ---- homing


@pytest.mark.parametrize(
    ("bit", "before", "after"), [("standing", 0x400, 0x1400), ("after", 0, 0x1400), ("never", 0, 0x1000)]
)
def test_bit_10_in_homing(bit: str, before: int, after: int) -> None:
    bench = drive(homing_bit=bit).put(0x6098, 37).enabled(HM)
    assert bench.status(0x3400) == before
    bench.control(0x1F).after(20)
    assert bench.status(0x3400) == after


def test_homing_methods_and_method_0() -> None:
    bench = drive(homing_methods=[37, 17, 18], accepts_no_homing=False)
    refused = {method: bench.try_put(0x6098, method) for method in (0, 35, 37, 17, 18)}
    assert refused == {0: INVALID, 35: INVALID, 37: "", 17: "", 18: ""}
    assert SingleDriveBench().try_put(0x6098, 0) == ""


@pytest.mark.parametrize("sign", [-1, 1])
def test_the_position_at_home_is_607c_with_its_sign(sign: int) -> None:
    bench = drive(home_offset_sign=sign).put(0x607C, 5_000).put(0x6098, 37).enabled(HM).control(0x1F)
    bench.after(50)
    assert bench.get(0x6064) == pytest.approx(sign * 5_000, abs=2)


# ---- units and limits


@pytest.mark.parametrize(
    ("unit", "asked", "rpm"),
    [("user", 2 * TURN, 120), ("counts", 20_000, 120), ("rpm", 120, 120), ("scaled", 120 * 512 * 10_000 // 1875, 120)],
)
def test_the_unit_of_velocities(unit: str, asked: int, rpm: float) -> None:
    """The encoder has 10 000 increments; `scaled` is the formula of a manual: rpm * 512 * resolution / 1875."""
    bench = SingleDriveBench(encoder_increments=10_000, behaviour={"velocity_unit": unit})
    bench.enabled(PV).put(0x60FF, asked).after(1_500)
    assert bench.read("speed") == pytest.approx(rpm, rel=0.01)
    assert bench.get(0x606C) == pytest.approx(asked, rel=0.02)


@pytest.mark.parametrize(("counts", "turns"), [(True, 0.0), (False, 1.0)])
def test_607d_0_0_is_literal_or_no_limit(counts: bool, turns: float) -> None:
    bench = drive(empty_limits_count=counts).put(0x607D, 0, 1).put(0x607D, 0, 2)
    bench.enabled(PP).put(0x607A, TURN).control(0x1F).after(3_000)
    assert bench.read("position") == pytest.approx(turns * 6.2832, abs=0.01)
    assert bench.status(0x0800) == (0x0800 if counts else 0)


@pytest.mark.parametrize(
    ("effect", "after", "bit_11", "moves"),
    [
        ("blocks", ENABLED, 0x0800, False),
        ("quick_stop", DISABLED, 0, False),
        ("fault", FAULT, 0, False),
        ("shown", ENABLED, 0x0800, True),
        ("ignored", ENABLED, 0, True),
    ],
)
def test_a_limit_switch(effect: str, after: int, bit_11: int, moves: bool) -> None:
    bench = drive(limit_switch=effect).enabled(PV).put(0x60FF, TURN)
    bench.after(500)
    bench.wire("axis.positive_limit", True).after(1_000)
    assert (state(bench), bench.status(0x0800)) == (after, bit_11)
    assert (bench.read("speed") > 50) is moves
    assert bench.get(0x603F) == (0x8612 if effect == "fault" else 0)


# ---- cyclic masters


def interpolate(bench: SingleDriveBench) -> None:
    bench.put(0x60C2, 10, 1).enabled(IP).control(0x1F)
    for step in range(1, 4):
        bench.put(0x60C1, step * 1_000, 1)


@pytest.mark.parametrize(("effect", "after"), [("quick_stop", DISABLED), ("stands", ENABLED)])
def test_interpolation_runs_dry(effect: str, after: int) -> None:
    bench = drive(empty_buffer=effect)
    interpolate(bench)
    bench.after(20)
    assert state(bench) == ENABLED
    bench.after(200)
    assert state(bench) == after


@pytest.mark.parametrize(
    ("loss", "option", "after", "code"), [("fault", 0, FAULT, 0x8700), ("connection", 2, DISABLED, 0)]
)
def test_a_missed_sync(loss: str, option: int, after: int, code: int) -> None:
    bench = drive(missed_syncs=2, sync_loss=loss).put(0x6007, option).put(0x1006, 10_000).enabled(PP)
    for _ in range(5):
        bench.send("080#")
        bench.after(10)
    bench.after(10)
    bench.send("080#")
    bench.after(29)
    assert state(bench) == ENABLED
    bench.after(5)
    assert (state(bench), bench.get(0x603F)) == (after, code)


@pytest.mark.parametrize(("counts", "after"), [(True, DISABLED), (False, ENABLED)])
def test_6007_when_the_node_leaves_operational(counts: bool, after: int) -> None:
    bench = drive(leaving_counts=counts).put(0x6007, 2).enabled(PP)
    bench.send("000#80 05")
    bench.after(5)
    assert state(bench) == after


# ---- the node


@pytest.mark.parametrize(
    ("rule", "operational", "preoperational"),
    [("free", "", ""), ("preoperational", DEVICE_STATE, ""), ("fixed", READ_ONLY, READ_ONLY)],
)
def test_the_mapping(rule: str, operational: str, preoperational: str) -> None:
    bench = drive(mapping=rule).put(0x1400, 0x8000_0205, 1)
    assert bench.try_put(0x1600, 0) == operational
    bench.send("000#80 05")
    assert bench.try_put(0x1600, 0) == preoperational


def test_sdo_answers_come_late_and_in_order() -> None:
    bench = drive(sdo_answer_ms=30, sdo_answer_most_ms=120)
    times = []
    for _ in range(20):
        assert bench.send(ASK_1000H) == []
        times.append(next(ms for ms in range(1, 200) if ANSWER_TO_1000H in bench.after(1)))
    assert 30 <= min(times) < 45
    assert 105 < max(times) <= 120
    fast = drive(sdo_answer_ms=2)
    assert (fast.send(ASK_1000H), fast.after(1.9), fast.after(0.1)) == ([], [], [ANSWER_TO_1000H])


def test_the_first_sdo_is_lost() -> None:
    bench = drive(loses_first_sdo=True)
    assert bench.send(ASK_1000H) == []
    assert bench.send(ASK_1000H) == [ANSWER_TO_1000H]
    bench.send("000#81 05")
    assert (bench.send(ASK_1000H), bench.send(ASK_1000H)) == ([], [ANSWER_TO_1000H])


def test_the_boot_up_comes_late_and_nothing_is_heard_before() -> None:
    bench = drive(boot_up_ms=1_000)
    assert bench.take() == []
    assert bench.send(ASK_1000H) == []
    assert bench.after(994) == []
    assert bench.after(2) == ["705#00"]
    assert ANSWER_TO_1000H in bench.send(ASK_1000H)


def test_pre_operational_follows_the_boot_up() -> None:
    bench = drive(says_preoperational=True)
    assert [frame for frame in bench.send("000#81 05") if frame.startswith("705")] == ["705#00", "705#7f"]


def test_nmt_counts_after_a_reset_of_the_node_only() -> None:
    bench = drive(needs_reset_node=True)
    bench.send("000#01 05")
    assert bench.point("nmt.state") == "pre_operational"
    bench.send("000#82 05", "000#01 05")
    assert bench.point("nmt.state") == "pre_operational"
    bench.send("000#81 05", "000#01 05")
    assert bench.point("nmt.state") == "operational"


def test_saving_takes_its_time_in_silence() -> None:
    bench = drive(save_ms=3_000, silent_while_saving=True)
    save = "605#23 10 10 01 73 61 76 65"
    assert bench.send(save) == []
    assert bench.send(ASK_1000H) == []
    assert bench.after(2_999) == []
    assert bench.after(1) == ["585#60 10 10 01 00 00 00 00"]
    assert bench.send(ASK_1000H) == [ANSWER_TO_1000H]


@pytest.mark.parametrize(
    ("asked", "answer"),
    [
        ("40 10 10 01 00 00 00 00", "43 10 10 01 01 00 00 00"), ("23 10 10 01 67 6e 61 77", "80 10 10 01 20 00 00 08"),
        ("2f 10 10 00 00 00 00 00", "80 10 10 00 02 00 01 06"),
    ],
)  # fmt: skip
def test_what_saves_nothing_is_answered_at_once(asked: str, answer: str) -> None:
    """Reading 1010h, a wrong signature, and a write of the number of its entries (CiA 301, 7.5.2.13)."""
    bench = drive(save_ms=3_000, silent_while_saving=True)
    assert bench.send(f"605#{asked}") == [f"585#{answer.upper()}"]


@pytest.mark.parametrize("name", NAMES)
def test_objects_that_a_personality_lacks_are_not_there(name: str) -> None:
    bench = SingleDriveBench(personality=name, behaviour=QUICK_ANSWERS)
    for index in rows_of(name).get("missing", ()):
        answer = bench.sdo(f"40 {index & 0xFF:02x} {index >> 8:02x} 00 00 00 00 00")
        assert answer == f"80 {index & 0xFF:02x} {index >> 8:02x} 00 00 00 02 06"


def test_1000h_is_not_that_of_the_eds() -> None:
    bench = SingleDriveBench(personality="late-and-thin", behaviour={"boot_up_ms": 0, "sdo_answer_most_ms": 0})
    bench.send(ASK_1000H)
    assert "585#43 00 10 00 00 00 02 00" in bench.after(40)


def test_6042h_in_hertz_is_a_dimension_factor() -> None:
    """A motor with two pairs of poles: 40 Hz are 1 200 min-1."""
    bench = drive(objects={"604C:01": 60, "604C:02": 2}).put(0x6042, 40).enabled(VL).control(0x7F)
    bench.after(3_000)
    assert bench.read("speed") == pytest.approx(1_200, rel=1e-3)


def test_wrong_keys_are_refused_at_their_place() -> None:
    for behaviour, place in (
        ({"homing_methods": [15]}, "behaviour.homing_methods"),
        ({"resets": 0}, "behaviour.resets"),
        ({"fault_reset": "twice"}, "behaviour.fault_reset"),
        ({"sdo_answer_ms": "5"}, "behaviour.sdo_answer_ms"),
        ({"missing": [0x1000]}, "behaviour.missing.0"),
        ({"objects": {"5FFF:00": 1}}, "behaviour.objects.5FFF:00"),
    ):
        with pytest.raises(ValueError, match=place):
            drive(**behaviour)


def test_a_personality_on_the_file_of_another_drive_leaves_out_what_that_lacks(tmp_path: Path) -> None:
    other = tmp_path / "other.eds"
    other.write_text(EDS.read_text().replace("605A", "5FFA"))  # an object of the maker instead of 605Ah
    bench = SingleDriveBench(eds=str(other), personality="step-by-step", behaviour=QUICK_ANSWERS)
    assert (bench.try_get(0x605A), bench.get(0x6007)) == (None, 3)


def test_any_object_may_be_missing() -> None:
    indices = sorted({variable.index for variable in SingleDriveBench().node.dictionary})
    for index in indices[1:]:
        bench = drive(missing=[index])
        bench.send("205#06 00", "205#0f 00", "080#")
        bench.after(3)


def test_an_rpdo_of_another_length_is_signalled() -> None:
    longer = SingleDriveBench()
    assert [frame for frame in longer.send("205#06 00 00") if frame.startswith("085")] == [
        "085#20 82 11 03 02 00 00 00"
    ]
    bench = SingleDriveBench().put(0x6060, PP)
    assert [frame for frame in bench.send("205#0f") if frame.startswith("085")] == ["085#10 82 11 01 02 00 00 00"]


@pytest.mark.parametrize(
    ("name", "own", "index"), [("robot-joint", {"modes": [1]}, 0x6060), ("own-units", {"homing_methods": [35]}, 0x6098)]
)
def test_a_mode_or_method_of_the_personality_gives_way_to_single_ones(
    name: str, own: dict[str, Any], index: int
) -> None:
    """The personality starts in mode 7, or with method 37, which these drives do not have."""
    bench = SingleDriveBench(personality=name, behaviour={"boot_up_ms": 0, "loses_first_sdo": False, **own})
    assert bench.node.dictionary.number(index, 0) in {0, *next(iter(own.values()))}
