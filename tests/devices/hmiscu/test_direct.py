"""A controller without a program: masters work one instance of each block by its pins."""

import pytest
from hmiscu_device_bench import PTO, DeviceBench

from fieldrig.clock import MS
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm

PWM = {"mode": "pwm"}
MOVE = {
    "MoveRelative.Velocity": 20_000,
    "MoveRelative.Distance": 40_000,
    "MoveRelative.Acceleration": 1_000,
    "MoveRelative.Deceleration": 500,
}


def moving(**channel: object) -> DeviceBench:
    """A controller 105 ms after the start, with the move of row 1 in section 9.3 of the digest ready."""
    bench = DeviceBench(channel_0=PTO | channel)
    for key, value in MOVE.items():
        bench.set(key, value)
    bench.run(105)
    return bench


def position(bench: DeviceBench) -> int:
    return int(bench.get("PTO00.Position"))


def test_a_move_starts_in_the_next_cycle_and_gives_all_pulses() -> None:
    bench = moving()
    bench.set("MoveRelative.Execute", True)
    bench.run(4)
    assert not bench.get("MoveRelative.Busy")
    bench.run(1)
    assert bench.get("MoveRelative.Busy")
    bench.run(2_749)
    assert not bench.get("MoveRelative.Done")
    bench.run(11)
    assert bench.get("MoveRelative.Done")
    assert (position(bench), bench.get("PTO00.Distance"), bench.get("PTO00.State")) == (40_000, 40_000, 0)


@pytest.mark.long
def test_pulses_travel_as_segments_on_the_wire_of_the_output() -> None:
    bench = moving(ramps="smooth")
    bench.set("MoveRelative.Execute", True)
    bench.run(3_000)
    trains = [signal for signal in bench.driven("pulse") if isinstance(signal, PulseTrain)]
    assert [(train.start_ns // MS, train.count) for train in trains[1:]] == [
        (110, 10_000), (1_110, 25_000), (2_360, 5_000), (2_860, 0),
    ]  # fmt: skip


def test_each_edge_travels_if_the_settings_say_so() -> None:
    bench = DeviceBench(channel_0=PTO, fast_signals="edges")
    for key, value in (MOVE | {"MoveRelative.Velocity": 1_000, "MoveRelative.Distance": 3}).items():
        bench.set(key, value)
    bench.set("MoveRelative.Execute", True)
    bench.run(200)
    assert [signal.value for signal in bench.driven("pulse")] == [False, *[True, False] * 3]


@pytest.mark.manual("SCU-012")
@pytest.mark.parametrize(
    ("mode", "pulses", "direction"),
    [("pulse/direction", "pulse", "direction"), ("direction/pulse", "direction", "pulse")],
)
def test_the_output_mode_swaps_both_outputs(mode: str, pulses: str, direction: str) -> None:
    bench = moving(output_mode=mode)
    bench.set("MoveRelative.Execute", True)
    bench.run(10)
    assert isinstance(bench.driven(pulses)[-1], PulseTrain)
    assert bench.level(direction) is True


@pytest.mark.manual("SCU-023", "SCU-025")
def test_drive_ready_is_input_2_and_stops_a_move_when_it_falls() -> None:
    bench = moving(aux="drive_ready")
    bench.set("MoveRelative.Execute", True)
    bench.run(10)
    assert bench.get("MoveRelative.Error")  # the contact was never closed
    bench.set("MoveRelative.Execute", False)
    bench.wire("drive.ready", True)
    bench.run(10)
    bench.set("PTO00.ResetError", True)
    bench.run(10)
    bench.set("MoveRelative.Execute", True)
    bench.run(500)
    assert (bench.get("PTO00.Moving"), bench.get("MoveRelative.Error")) == (True, False)
    bench.wire("drive.ready", False)
    bench.run(15)
    assert (bench.get("MoveRelative.Error"), bench.get("MoveRelative.ErrID")) == (True, 5)
    bench.run(200)
    assert (bench.get("PTO00.State"), bench.get("PTO00.Frequency")) == (4, 0)


@pytest.mark.manual("SCU-018", "SCU-039", "SCU-099")
def test_leaving_run_stops_a_move_with_the_fast_stop() -> None:
    bench = moving()
    bench.set("MoveRelative.Execute", True)
    bench.run(1_505)
    bench.set("plc/command", "stop")
    before = position(bench)
    bench.run(1_000)
    # 20 kHz at 500 Hz/ms: 40 ms and 400 pulses
    assert position(bench) - before == pytest.approx(400, abs=2)
    assert bench.get("PTO00.State") == 4


@pytest.mark.manual("SCU-056")
def test_a_warm_start_brings_the_configured_parameters_back() -> None:
    bench = DeviceBench(channel_0=PTO | {"start_frequency_hz": 1_000})

    def read() -> object:
        bench.set("GetParam.Execute", False)
        bench.run(10)
        bench.set("GetParam.Execute", True)
        bench.run(10)
        return bench.get("GetParam.ParamValue")

    assert read() == 1_000
    bench.set("SetParam.Param_Value", 2_000)
    bench.set("SetParam.Execute", True)
    bench.run(10)
    assert read() == 2_000
    bench.set("plc/command", "reset warm")
    bench.set("plc/command", "run")
    assert read() == 1_000


@pytest.mark.long
def test_pins_keep_their_type() -> None:
    bench = moving()
    with pytest.raises(ValueError, match="expected a whole number from 0 to 4294967295, got 4294967296"):
        bench.set("MoveRelative.Distance", 1 << 32)
    with pytest.raises(ValueError, match="expected true or false, got 2"):
        bench.set("MoveRelative.Execute", 2)


@pytest.mark.manual("SCU-003", "SCU-010")
def test_two_pwm_channels_have_their_outputs_and_inputs() -> None:
    bench = DeviceBench(
        channel_0=PWM | {"enable_input": True},
        channel_1=PWM,
        terminals={"FQ0": "heater", "FQ1": "fan", "DI0": "release"},
    )
    for name, frequency, duty in (("PWM00", 10_000, 50), ("PWM01", 100, 25)):
        bench.set(f"{name}.Frequency", frequency)
        bench.set(f"{name}.Duty", duty)
    bench.set("PWM00.EN_Enable", True)
    bench.set("PWM01.F_Enable", True)
    bench.run(20)
    assert (bench.get("PWM00.InFrequency"), bench.get("PWM01.InFrequency")) == (False, True)
    bench.wire("release", True)
    bench.run(20)
    heater, fan = bench.driven("heater")[-1], bench.driven("fan")[-1]
    assert isinstance(heater, Pwm)
    assert isinstance(fan, Pwm)
    assert (heater.value, heater.frequency, fan.value, fan.frequency) == (50, 1_000, 25, 10)
    bench.set("plc/command", "stop")
    assert (bench.level("heater"), bench.level("fan")) == (0, 0)


@pytest.mark.long
def test_a_channel_with_another_name_is_also_found_by_its_usual_one() -> None:
    bench = DeviceBench(channel_0=PWM | {"variable": "Heater"})
    bench.set("PWM00.Duty", 7)
    assert bench.get("Heater.Duty") == 7


def test_without_channels_there_are_no_blocks() -> None:
    bench = DeviceBench()
    assert bench.device.find("PTO00.Frequency") is None
    assert bench.device.find("PWM00.Duty") is None


@pytest.mark.manual("SCU-029")
def test_a_reset_without_effect_says_why(caplog: pytest.LogCaptureFixture) -> None:
    """Once, a rising ResetError was lost without a sign while the drive was not ready."""
    bench = moving(aux="drive_ready")
    bench.wire("drive.ready", False)
    bench.run(200)
    bench.set("MoveRelative.Execute", False)
    for problem in ("the drive is not ready", ""):
        bench.set("PTO00.ResetError", True)
        bench.run(20)
        assert (bench.get("PTO00.ResetProblem"), bench.get("PTO00.State") == 4) == (problem, bool(problem))
        assert ("the drive is not ready" in caplog.text) is bool(problem)
        caplog.clear()
        bench.set("PTO00.ResetError", False)
        bench.wire("drive.ready", True)
        bench.run(200)
