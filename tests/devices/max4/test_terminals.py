"""Inputs and outputs, measuring inputs, encoders."""

from itertools import count

import pytest
from max4_bench import Bench, GivenSetValues

from fieldrig.clock import MS
from fieldrig_bus.wires import Motion


@pytest.mark.manual("PD-022")
def test_inputs_and_outputs_are_wires() -> None:
    bench = Bench(inputs={"I_bStartS1": "panel.s1"}, outputs={"O_bH1": "panel.h1"}).run(100)
    assert bench.get("I_bStartS1.Value") is False
    bench.signal("panel.s1", True).run(1)
    assert bench.get("I_bStartS1.Value") is True
    bench.set("O_bH1.Value", True).run(1)
    assert bench.wires[-1][1:] == ("panel.h1", True)


def test_an_input_without_a_wire_can_be_set() -> None:
    bench = Bench(inputs={"I_bFree": ""}).run(100).set("I_bFree.Value", True)
    assert bench.max4.firmware.tree.get("I_bFree.Value") is True


@pytest.mark.manual("PD-194")
def test_measuring_input_latches_between_two_cycles() -> None:
    bench = Bench(simulated=("belt",), measuring_inputs={"I_Probe": "probe"}).run(100).enable("belt")
    bench.axis("belt").follow(GivenSetValues(count(0, 4_000)))
    bench.run(400)
    last = bench.axis("belt").position
    while bench.axis("belt").position == last:
        bench.run(0.25)
    before = bench.axis("belt").position
    bench.run(1).signal("probe", True).run(8)
    assert bench.get("I_Probe.Count") == 1
    assert float(bench.get("I_Probe.Position_belt")) - before == pytest.approx(1_000, abs=260)
    bench.signal("probe", True).run(8)
    assert bench.get("I_Probe.Count") == 1, "no edge"


@pytest.mark.manual("PD-181")
@pytest.mark.manual("PD-182")
def test_logic_encoder_runs_in_the_real_time_process() -> None:
    bench = Bench(logic_encoders=["MasterEncoder"]).run(100)
    bench.set("MasterEncoder.Position", 10.0).set("MasterEncoder.Velocity", 50.0).run(2_000)
    assert bench.get("MasterEncoder.Position") == pytest.approx(110.0)
    bench.set("MasterEncoder.Velocity", 0.0).run(100)
    assert bench.get("MasterEncoder.Position") == pytest.approx(110.0)


@pytest.mark.manual("PD-182")
def test_master_encoder_counts_its_wire_every_cycle() -> None:
    bench = Bench(master_encoders={"Conveyor": "roll.encoder"}).run(100)
    bench.outside.link("wires").send(Motion("roll.encoder", 500.0, "count", 100 * MS, 1_000.0))
    bench.run(1_000)
    assert bench.get("Conveyor.Position") == pytest.approx(1_500.0)
    assert bench.get("Conveyor.Velocity") == 1_000.0
