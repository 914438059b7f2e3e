"""Every fault of the shipped rigs: the machine is safe, does not start by itself, and comes back as documented."""

from collections.abc import Callable
from typing import Any

import pytest
from fault_choices import CONFIGS, faults_of

from fieldrig.clock import S
from fieldrig.pytest_plugin import RigMaker
from fieldrig.rig import Rig

pytestmark = pytest.mark.long

ENABLED, S1_ON = 1, 3


def wait(rig: Rig, seconds: float) -> None:
    rig.run_until(rig.now_ns + round(seconds * S))


def until(rig: Rig, is_so: Callable[[], object], seconds: int) -> None:
    end_ns = rig.now_ns + seconds * S
    while not is_so():
        assert rig.now_ns < end_ns
        wait(rig, 0.1)


def named(rig: str) -> list[Any]:
    return [
        pytest.param(where, fault, id="-".join(map(str, (where, *fault.values())))) for where, fault in faults_of(rig)
    ]


# ---- the conveyor


AXES = {"belt": 250.0, "infeed": 250.0, "cutter": 250.0, "outfeed": 300.0}
"""The drives with the speed of their rollers in mm/s while the machine runs: the outfeed is 1.2 times as fast."""
MM_S_PER_RPM = 31.41592653589793 / 60


def speeds(rig: Rig) -> dict[str, float]:
    return {axis: abs(float(rig.get(axis, "speed"))) * MM_S_PER_RPM for axis in AXES}


def conveyor_runs(rig: Rig) -> bool:
    return all(speed == pytest.approx(AXES[axis], abs=2) for axis, speed in speeds(rig).items())


def conveyor_stands(rig: Rig) -> bool:
    return max(speeds(rig).values()) < 1


@pytest.mark.parametrize(("where", "fault"), named("conveyor-virtual.yaml"))
def test_conveyor(fieldrig_rig: RigMaker, where: str, fault: dict[str, object]) -> None:
    """A lost axis stops all of them; docs/conveyor.md: S1 off, `DiagQuit`, S1 on."""
    rig = fieldrig_rig(CONFIGS / "conveyor-virtual.yaml")
    until(rig, lambda: rig.get("max4", "booted"), 60)
    wait(rig, 0.5)
    rig.set("panel", "6200:01", S1_ON)
    wait(rig, 3)
    assert conveyor_runs(rig)
    number = rig.add_fault(where, fault)
    wait(rig, 2)
    goes_on = conveyor_runs(rig)
    assert goes_on or conveyor_stands(rig)
    fed = rig.get("line", "fed")
    rig.clear_fault(where, number)
    if fault["what"] == "overrun":  # the program does not run; a drive stops by its following error
        wait(rig, 1)
        assert rig.get("max4", "ConveyerBelt.DiagCode") == 3196
    for _ in range(30):
        wait(rig, 0.1)
        assert conveyor_runs(rig) if goes_on else conveyor_stands(rig)
    assert (rig.get("line", "fed") != fed) is goes_on
    until(rig, lambda: rig.get("max4", "booted"), 60)
    rig.set("panel", "6200:01", ENABLED)
    until(rig, lambda: conveyor_stands(rig), 10)
    wait(rig, 1)
    rig.set("max4", "DiagQuit", True)
    wait(rig, 1)
    assert (rig.get("max4", "DiagCode"), conveyor_stands(rig)) == (0, True)
    rig.set("panel", "6200:01", S1_ON)
    wait(rig, 3)
    assert conveyor_runs(rig)


@pytest.mark.parametrize("axis", AXES)
def test_a_short_fault_of_any_axis_stops_the_conveyor(fieldrig_rig: RigMaker, axis: str) -> None:
    """Once, only the belt was watched: the others started again by themselves when their fault was over."""
    rig = fieldrig_rig(CONFIGS / "conveyor-virtual.yaml")
    until(rig, lambda: rig.get("max4", "booted"), 60)
    wait(rig, 0.5)
    rig.set("panel", "6200:01", S1_ON)
    wait(rig, 3)
    rig.add_fault(axis, {"what": "enable_lost", "duration_ms": 300})
    wait(rig, 1)
    fed = rig.get("line", "fed")
    for _ in range(20):
        wait(rig, 0.1)
        assert conveyor_stands(rig)
    assert rig.get("line", "fed") == fed


# ---- the feeder


def feed(rig: Rig) -> tuple[int, float]:
    """Ask for a label, and return how many more feeds there are and how far the web has moved, in labels."""
    before, place = int(rig.get("feeder", "g_udiFeeds")), float(rig.get("web", "position"))
    rig.set("feeder", "panel.key1", True)
    wait(rig, 2)
    rig.set("feeder", "panel.key1", False)
    wait(rig, 0.1)
    return int(rig.get("feeder", "g_udiFeeds")) - before, round((float(rig.get("web", "position")) - place) / 0.1, 3)


WHOLE = (1, 1.0)


@pytest.mark.parametrize(("where", "fault"), named("feeder-virtual.yaml"))
def test_feeder(fieldrig_rig: RigMaker, where: str, fault: dict[str, object]) -> None:
    """A drive with an alarm stands until the reset of docs/feeder.md: the fault ends, key 2, and the next request."""
    rig = fieldrig_rig(CONFIGS / "feeder-virtual.yaml")
    until(rig, lambda: rig.get("feeder", "panel.line1") == "ready", 120)
    assert feed(rig) == WHOLE
    rig.set("feeder", "panel.key1", True)
    wait(rig, 0.15)
    number = rig.add_fault(where, fault)
    wait(rig, 30)
    rig.set("feeder", "panel.key1", False)
    wait(rig, 0.1)
    is_ready = rig.get("feeder", "panel.line1") == "ready"
    if not is_ready:
        assert feed(rig) == (0, 0.0)
    rig.clear_fault(where, number)
    wait(rig, 0.1)
    is_in_error = rig.get("feeder", "g_bError")
    assert is_in_error == (where in ("stepper", "feeder") and fault["what"] != "exit_runtime")
    if is_in_error:
        assert (feed(rig), rig.get("feeder", "PTO00.State")) == ((0, 0.0), 4)
        rig.set("feeder", "panel.key2", True)
        wait(rig, 0.5)
        rig.set("feeder", "panel.key2", False)
        assert (rig.get("stepper", "ready"), rig.get("feeder", "PTO00.State")) == (True, 0)
    until(rig, lambda: rig.get("feeder", "panel.line1") == "ready", 300)
    assert feed(rig) == WHOLE


# ---- the labelling machine

IDLE, RUNNING, ERROR = 2, 3, 9
LABELLER = ("belt", "cutter", "paper", "stacker")


def state(rig: Rig) -> object:
    return rig.get("plc", "DOW_State")


def start_labeller(rig: Rig) -> None:
    until(rig, lambda: state(rig) == IDLE, 20)
    rig.set("plc", "DIF_Start", True)
    until(rig, lambda: labeller_runs(rig), 5)
    rig.set("plc", "DIF_Start", False)
    wait(rig, 2)


def labeller_runs(rig: Rig) -> bool:
    return state(rig) == RUNNING and float(rig.get("belt", "speed")) == pytest.approx(4.0, abs=0.05)


def labeller_stands(rig: Rig) -> bool:
    return all(abs(float(rig.get(axis, "speed"))) < 0.01 for axis in LABELLER)


@pytest.mark.parametrize(("where", "fault"), named("pam-machine-virtual.yaml"))
def test_labelling_machine(fieldrig_rig: RigMaker, where: str, fault: dict[str, object]) -> None:
    """An axis in error stops all of them until Reset and Start; after a low battery the PAM starts again."""
    rig = fieldrig_rig(CONFIGS / "pam-machine-virtual.yaml")
    start_labeller(rig)
    number = rig.add_fault(where, fault)
    wait(rig, 3)
    goes_on = labeller_runs(rig)
    assert goes_on or labeller_stands(rig)
    assert not goes_on or where not in LABELLER or fault["what"] in ("motor_temperature", "jam")
    assert rig.get("plc", "DOF_Error") == (where in LABELLER and not goes_on)
    rig.clear_fault(where, number)
    for _ in range(30):
        wait(rig, 0.1)
        if where == "pam":
            assert float(rig.get("belt", "speed")) == 0.0  # it looks for the zero of the knife, as after each power-on
        else:
            assert labeller_runs(rig) if goes_on else labeller_stands(rig)
    if fault["what"] == "low_battery":
        rig.set("pam", "reset", True)
        wait(rig, 1)
    elif goes_on:
        press(rig, "key2")
    elif where in LABELLER:
        assert state(rig) == ERROR
        press(rig, "key3")
    start_labeller(rig)
    assert labeller_runs(rig)


def press(rig: Rig, key: str) -> None:
    for level in (True, False):
        rig.set("keys", key, level)
        wait(rig, 0.3)
