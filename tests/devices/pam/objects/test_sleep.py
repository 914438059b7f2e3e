"""A network of pipes at rest sleeps: nothing may differ from a network that computes in every period."""

import pytest
from hypothesis import given, settings
from pam_pipelines import Action, Connect, Do, Machine, Mark, Put, scripts
from pam_programs import HEADER
from pam_whole import WholePam

from fieldrig.testing import plain_forms
from fieldrig_devices.pam.objects.pipes import SLEEP

Script = list[tuple[Action, int]]


def both(script: Script) -> Machine:
    """Play a script with pipes that sleep and with pipes that compute, and return the machine that slept."""
    with plain_forms(SLEEP.name):
        plain = Machine().play(script)
    machine = Machine()
    for cycle, (found, wanted) in enumerate(zip(machine.play(script), plain, strict=True)):
        assert found == wanted, f"cycle {cycle}"
    return machine


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(scripts)
def test_pipes_that_sleep_show_what_pipes_that_compute_show(script: Script) -> None:
    both(script)


MOVES = (
    HEADER
    + """
TMP_GENERATOR TMP_A; TRAVEL_SPEED = {speed}; ACCELERATION = 1000; INITIAL_POSITION = 0; POSITION_RANGE = -1000 1000;
  PERIOD = 0.001; END
SINK SNK_A; END
CONVERTER CNV_A; DESTINATION = SNK_A; MODE = VALUE; END
INTERNAL WORD_VAR IWV_N; INTERNAL FLAG_VAR IFV_Go;
TASK TSK_A; SPECS CYCLES = 1; END_SPECS
  EVENTS ON_EVENT IFV_Go XEQ_SEQUENCE SEQ_A; END_EVENTS
  SEQUENCE SEQ_A;
    CNV_A << TMP_A; WAIT_TIME 100;
    {moves}
  END_SEQUENCE
  POWERON IFV_Go <- set; END_POWERON
END_TASK
"""
)


@pytest.mark.long
@pytest.mark.parametrize("speed", [1, 10, 20, 100])
def test_a_sequence_goes_on_after_moves_by_round_numbers(speed: int) -> None:
    """A tenth of them was never seen to end: the network fell asleep one period before the generator was ready."""
    moves = "".join(
        f"TMP_A <- absolute_move({target}); CONDITION TMP_A ? ready; IWV_N <- IWV_N + 1;\n" for target in range(1, 31)
    )
    pam = WholePam(MOVES.format(speed=speed, moves=moves))
    pam.run(3000 + 30_000 // speed)
    assert (pam["IWV_N"], pam.messages[-1]) == (30, "07..M017")


@pytest.mark.long
def test_a_corrector_takes_the_second_event_at_rest_as_the_first() -> None:
    """The flow rests at 0 before the first event, and at 180 before the second, which asks for 360."""
    machine = both(
        [
            (Connect(["CNV_Sink", "COR_A", "TMP_A"]), 100),
            (Do("COR_A", "trigger", 180.0), 1),
            (Mark(0), 1),
            (Do("COR_A", "start_correction"), 1000),
            (Do("COR_A", "trigger", 360.0), 1),
            (Mark(0), 1),
        ]
    )
    assert machine.ask("COR_A", "latched_value") == pytest.approx(180, abs=1e-9)
    assert machine.ask("COR_A", "latched_d_value") == 0
    assert machine.ask("COR_A", "correction") == pytest.approx(180, abs=1e-9)


@pytest.mark.manual("PAML-560")
def test_a_learned_time_ends_while_the_flow_stands() -> None:
    """The reference at 30 comes 100 ms after the origin at 20; later the flow comes to rest at 22 before it."""
    reference = Do("TRC_A", "install_reference", "POSITIVE", "IMMEDIATE", 30.0, 0.0)
    script: Script = [
        (Connect(["CNV_Sink", "MUL_A", "TMP_A"]), 100),
        (Put("TMP_A.TRAVEL_SPEED", 100.0), 1),
        (Do("MUL_A", "learn"), 1),
        (reference, 1),
        (Do("TMP_A", "absolute_move", 40.0), 600),
        (Do("TMP_A", "absolute_move", 0.0), 600),
        (Do("MUL_A", "execute"), 1),
        (reference, 1),
        (Do("TMP_A", "absolute_move", 22.0), 500),
    ]
    both(script)
    starts = [cycle for cycle, shown in enumerate(Machine().play(script)) if "RTN_" in shown]
    assert [starts[1] - starts[0], starts[3] - starts[2]] == [100, 100]


def test_a_derivator_behind_an_amplifier_comes_to_zero_after_the_slew() -> None:
    machine = both([(Connect(["CNV_Sink", "DER_A", "AMP_A", "TMP_A"]), 100), (Put("AMP_A.GAIN", 3.0), 100)])
    assert machine.ask("DER_A", "value") == 0


def test_a_pipe_at_rest_takes_its_analog_output_back_from_a_program() -> None:
    machine = both([(Connect(["CNV_Volts", "TMP_A"]), 50), (Put("PAO_A", 20.0), 0)])
    assert machine.item("PAO_A").value() == 20
    machine.cycle()
    assert machine.item("PAO_A").value() == 0


@pytest.mark.parametrize(
    ("pipe", "cycles"),
    [
        (["CNV_Axis", "PHA_A", "CMP_A", "AMP_A", "TMP_B"], 1),
        (["CNV_Set", "COR_A", "DIS_A", "MUL_A", "CAM_A", "DER_A", "TMP_A"], 3),
    ],
)
def test_pipes_at_rest_do_sleep(monkeypatch: pytest.MonkeyPatch, pipe: list[str], cycles: int) -> None:
    machine = Machine()
    machine.play([(Connect(pipe), 100)])
    computed: list[float] = []
    block = machine.item(pipe[1]).block
    transform = block.transform

    def counted(value: float) -> float:
        computed.append(value)
        return float(transform(value))

    monkeypatch.setattr(block, "transform", counted)
    machine.cycle(50)
    assert computed == []
    machine.do("TMP_B" if "TMP_B" in pipe else "TMP_A", "position", 20.0)
    machine.cycle(cycles + 2)
    assert computed
