"""The edges of Execute and the status pins of the blocks (manual 1731 to 1762; digest 4.8 and 5)."""

import pytest
from hmiscu_bench import FINAL, PtoBench, shown
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS, S
from fieldrig_devices.hmiscu.enumerations import ErrorId


@pytest.mark.manual("SCU-080", "SCU-082")
def test_the_status_goes_with_execute_once_the_block_has_ended() -> None:
    bench = PtoBench()
    bench.relative(Distance=100)
    assert shown(bench.move) == {"Busy", "Active"}
    bench.cycle(S)
    assert shown(bench.move) == {"Done"}
    bench.cycles(3)
    assert shown(bench.move) == {"Done"}
    bench.release(bench.move)
    assert shown(bench.move) == set()


@pytest.mark.manual("SCU-082")
def test_a_block_whose_execute_fell_early_shows_its_end_for_one_cycle() -> None:
    bench = PtoBench()
    bench.relative(Distance=100)
    bench.release(bench.move)
    assert shown(bench.move) == {"Busy", "Active"}
    bench.cycle(S)
    assert shown(bench.move) == {"Done"}
    bench.cycle(10 * MS)
    assert shown(bench.move) == set()


def test_the_axis_keeps_its_velocity_when_execute_falls() -> None:
    bench = PtoBench()
    bench.run()
    bench.cycle(2 * S)
    assert shown(bench.velocity) == {"InVelocity"}
    bench.release(bench.velocity)
    bench.cycle(S)
    assert shown(bench.velocity) == set()
    assert bench.simple.outputs["Moving"]
    assert bench.frequency == 20_000


@pytest.mark.manual("SCU-083")
def test_a_new_edge_gives_no_feedback_for_the_earlier_action() -> None:
    bench = PtoBench()
    bench.relative(Distance=1_000_000)
    bench.cycle(S)
    bench.relative(Distance=1_000_000)
    assert shown(bench.move) == {"Error"}
    assert bench.move.outputs["ErrID"] == ErrorId.PTO_INVALID_PARAMETER


@pytest.mark.manual("SCU-077", "SCU-038")
def test_inputs_count_at_the_edge_only() -> None:
    bench = PtoBench()
    bench.relative(Distance=1_000)
    bench.move.inputs.update(Distance=5_000, Velocity=1)
    bench.cycle(10 * MS)
    bench.rest_ns()
    assert bench.sent == 1_000


@pytest.mark.manual("SCU-078")
def test_a_pin_that_is_left_alone_keeps_its_value() -> None:
    bench = PtoBench()
    bench.relative(Distance=50)
    bench.cycle(S)
    bench.execute(bench.move)
    bench.cycle(S)
    assert bench.sent == 100
    assert bench.simple.outputs["Distance"] == 50


@pytest.mark.manual("SCU-032", "SCU-098")
def test_the_reference_goes_from_block_to_block() -> None:
    bench = PtoBench()
    bench.cycle()
    assert bench.simple.outputs["PTO_REF"] == 1
    assert [block.outputs["PTO_REF_OUT"] for block in bench.blocks[1:]] == [1] * 6


@pytest.mark.manual("SCU-076")
def test_a_reference_that_changes_while_the_block_is_active_changes_nothing() -> None:
    bench = PtoBench()
    bench.relative(Distance=100)
    bench.move.inputs["PTO_REF_IN"] = 9
    bench.cycle(MS)
    assert shown(bench.move) == {"Busy", "Active"}
    bench.cycle(S)
    assert shown(bench.move) == {"Done"}


@pytest.mark.manual("SCU-028", "SCU-031", "SCU-096")
def test_the_axis_shows_its_state_frequency_and_distance() -> None:
    bench = PtoBench()
    bench.run(Velocity=10_000)
    bench.cycle(500 * MS)
    shows = bench.simple.outputs
    assert (shows["Moving"], shows["Stopping"]) == (True, False)
    assert shows["Frequency"] == pytest.approx(5_000, abs=2)
    assert shows["Distance"] == pytest.approx(1_250, abs=2)
    bench.cycle(S)
    bench.halt()
    bench.cycle(100 * MS)
    assert (shows["Moving"], shows["Stopping"]) == (False, True)
    bench.rest_ns()
    bench.release(bench.stop)
    bench.cycle()
    assert (shows["Moving"], shows["Stopping"], shows["Frequency"]) == (False, False, 0)
    bench.relative(Distance=3)
    bench.cycle(S)
    assert shows["Distance"] == 3


@pytest.mark.manual("SCU-057", "SCU-058", "SCU-056")
def test_parameters_are_written_and_read_and_their_outputs_hold() -> None:
    bench = PtoBench(start_frequency_hz=300)
    bench.execute(bench.get, Param=0)
    assert shown(bench.get) == {"Done"}
    assert bench.get.outputs["ParamValue"] == 300
    bench.execute(bench.set, Param=1, Param_Value=400)
    bench.execute(bench.get, Param=1)
    assert bench.get.outputs["ParamValue"] == 400
    for block in (bench.get, bench.set):
        bench.release(block)
        assert shown(block) == {"Done"}
    bench.relative(Velocity=20_000, Distance=3)
    assert bench.frequency == 400  # a jog goes out at the stop frequency


@pytest.mark.manual("SCU-064")
@pytest.mark.parametrize("selector", [2, 255])
def test_other_parameters_are_unknown_and_leave_the_axis_alone(selector: int) -> None:
    bench = PtoBench()
    for block in (bench.get, bench.set):
        bench.execute(block, Param=selector)
        assert block.outputs["ErrID"] == ErrorId.PTO_UNKNOW_PARAMETER
    bench.cycle()
    assert not bench.simple.outputs["PTOError"]


def test_a_parameter_above_the_maximum_is_refused() -> None:
    bench = PtoBench(maximum_frequency_hz=1_000)
    bench.execute(bench.set, Param=0, Param_Value=1_001)
    assert bench.set.outputs["ErrID"] == ErrorId.PTO_INVALID_PARAMETER
    bench.execute(bench.get, Param=0)
    assert bench.get.outputs["ParamValue"] == 0


def test_a_parameter_that_is_set_during_a_move_counts_from_the_next_command() -> None:
    bench = PtoBench()
    bench.run()
    bench.cycle(2 * S)
    bench.execute(bench.set, Param=1, Param_Value=15_000)
    bench.channel.fail(bench.now_ns)
    before_ns = bench.now_ns
    assert (bench.rest_ns() - before_ns) / S == pytest.approx(0.04, abs=1e-4)  # 20 kHz to 0 at 500 Hz/ms


@pytest.mark.manual("SCU-059")
def test_the_diagnosis_block_is_reset_by_execute() -> None:
    bench = PtoBench()
    bench.execute(bench.diag)
    assert shown(bench.diag) == {"Done"}
    bench.release(bench.diag)
    assert shown(bench.diag) == set()


@pytest.mark.long
@pytest.mark.manual("SCU-079")
@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(["move", "velocity", "stop", "simple"]), st.booleans(), st.integers(1, 400))))
def test_with_execute_exactly_one_status_is_true(steps: list[tuple[str, bool, int]]) -> None:
    bench = PtoBench()
    ramps = {"Velocity": 5_000, "Distance": 300, "Acceleration": 100, "Deceleration": 100}
    for block in bench.blocks[1:4]:
        block.inputs.update({pin: value for pin, value in ramps.items() if pin in block.inputs})
    for name, level, after_ms in steps:
        block = getattr(bench, name)
        block.inputs["ResetError" if name == "simple" else "Execute"] = level
        bench.cycle(after_ms * MS)
        for motion in (bench.move, bench.velocity, bench.stop):
            status = [pin for pin in (*FINAL, "Busy") if motion.outputs.get(pin)]
            assert len(status) == 1 if motion.inputs["Execute"] else len(status) <= 1
