"""The labelling machine in virtual time: it finds its zero, follows its master, keeps its register, and recovers."""

from pathlib import Path

import pytest

from fieldrig import MS, Rig, RigMaker, S

RIG = Path(__file__).with_name("pam-machine.yaml")
IDLE, RUNNING, ERROR = 2, 3, 9
PRESSED = 300 * MS


@pytest.fixture
def rig(fieldrig_rig: RigMaker) -> Rig:
    rig = fieldrig_rig(RIG)
    until_state(rig, IDLE)
    return rig


@pytest.fixture
def running(rig: Rig) -> Rig:
    rig.set("plc/DIF_Start", True)
    until_state(rig, RUNNING)
    rig.run_for(S)
    return rig


def until_state(rig: Rig, state: int, seconds: int = 10) -> None:
    rig.until(lambda: rig.get("plc/DOW_State") == state, within=seconds * S)


def press(rig: Rig, key: str) -> None:
    rig.set("keys", key, True)
    rig.run_for(PRESSED)
    rig.set("keys", key, False)


def test_knife_finds_its_zero_switch(rig: Rig) -> None:
    assert float(rig.get("cams/position")) == pytest.approx(3.0, abs=0.01)  # the edge, in rad
    assert rig.get("cutter/position") == 0.0


def test_axes_follow_the_master_without_a_jump_of_their_speed(running: Rig) -> None:
    last = {axis: float(running.get(axis, "set_speed")) for axis in ("belt", "cutter", "paper")}
    for _ in range(1500):
        running.run_for(MS)
        for axis, before in last.items():
            speed = float(running.get(axis, "set_speed"))
            assert abs(speed - before) < 0.05, axis  # turns a second in a millisecond
            last[axis] = speed
    assert float(running.get("belt/set_speed")) == pytest.approx(4.0, abs=1e-4)  # 400 mm/s at 100 mm a turn


def test_knife_stands_still_in_the_first_third_of_a_pitch(running: Rig) -> None:
    speeds = {}
    for _ in range(1000):
        running.run_for(MS)
        place = float(running.get("belt/set_position")) / 4  # of the pitch
        speeds[place] = float(running.get("cutter/set_speed"))
    assert max(abs(speed) for place, speed in speeds.items() if 0.03 < place < 0.3) < 0.05
    assert max(speeds.values()) > 2.5


def test_marks_come_into_register(running: Rig) -> None:
    places: list[float] = []
    corrections: set[float] = set()
    was_seen = True
    while len(places) < 5:
        running.run_for(MS)
        corrections.add(float(running.get("plc/DOR_Register")))
        is_seen = bool(running.get("marks/mark"))
        if is_seen and not was_seen:
            places.append(float(running.get("belt/set_position")) * 25)  # mm of the label that the cam has fed
        was_seen = is_seen
    assert abs(places[0] - 30) > 5
    assert places[-1] == pytest.approx(30, abs=0.5)
    assert max(corrections) == pytest.approx(places[0] - 30, abs=0.5)  # as the PLC has seen it


def test_each_product_is_counted_and_stacked(running: Rig) -> None:
    running.run_for(6 * S)
    assert int(running.get("plc/DOL_Products")) >= 3
    assert max(_places_of_stacker(running)) == pytest.approx(6.0, abs=0.01)  # 120 mm at 20 mm a turn


def _places_of_stacker(rig: Rig) -> list[float]:
    found = []
    for _ in range(100):
        rig.run_for(10 * MS)
        found.append(float(rig.get("stacker/position")))
    return found


def test_stop_key_stops_at_the_end_of_a_pitch(running: Rig) -> None:
    press(running, "key2")
    until_state(running, IDLE)
    running.run_for(20 * MS)
    assert float(running.get("belt/set_position")) == pytest.approx(0.0, abs=1e-6)
    assert not running.get("plc/DOF_Running")
    assert not running.get("keys/out101")


def test_plc_moves_the_guide(rig: Rig) -> None:
    rig.set("plc/DIL_Guide", 50)
    rig.run_for(3 * S)
    assert abs(float(rig.get("rail/position")) - 20.25 - 50) < 3  # pulses from where it stood


def test_error_of_an_axis_stops_the_machine_and_reset_recovers_it(running: Rig) -> None:
    fault = running.add_fault("cutter", {"what": "resolver"})
    until_state(running, ERROR)
    assert running.get("plc/DOF_Error")
    assert (running.get("pam/display"), running.get("pam/display.blinks")) == ("0080E001", True)
    running.run_for(S)
    assert running.get("belt/set_speed") == 0.0
    running.clear_fault("cutter", fault)
    press(running, "key3")
    until_state(running, IDLE, 15)
    assert not running.get("plc/DOF_Error")
    assert not running.get("pam/display.blinks")


def test_an_axis_that_lags_behind_stops_the_machine_and_reset_recovers_it(running: Rig) -> None:
    running.set("belt/load_torque", 100.0)  # Nm, more than the motor has
    until_state(running, ERROR)
    assert "SERVO_LAG_ERROR" in str(running.get("belt/errors"))
    assert not running.get("plc/DOF_Running")
    running.set("belt/load_torque", 0.0)
    running.run_for(3 * S)
    press(running, "key3")
    until_state(running, IDLE, 15)
    assert not running.get("plc/DOF_Error")


def test_broken_ring_is_fatal_for_the_pam_and_stops_the_axes(running: Rig) -> None:
    running.add_fault("pamring", {"what": "break", "after": "cutter"})
    running.run_for(2 * S)
    assert (running.get("pam/state"), running.get("pam/display"), running.get("pam/led")) == (
        "fatal",
        "0680F010",
        "on",
    )
    assert {axis: running.get(axis, "speed") for axis in ("belt", "cutter", "paper")} == dict.fromkeys(
        ("belt", "cutter", "paper"), 0.0
    )
    assert running.get("keys/display") in ("F 2", "F-6")
