"""A lamp with a program that has a mistake, and a search for it: what tests of the search share."""

from pathlib import Path

from st_tests import LAMP_RIG

from fieldrig_devices.search.corpus import Corpus
from fieldrig_devices.search.crew import Bench, LocalCrew
from fieldrig_devices.search.plan import load_plan
from fieldrig_devices.search.search import Limits, Search
from fieldrig_devices.search.strategy import WHOLE, Shard

PROGRAM = """\
VAR_GLOBAL presses : INT; END_VAR
PROGRAM PLC_PRG
VAR
  switch AT %IX0.0 : BOOL;
  lamp AT %QX0.0 : BOOL;
  hold : TON;
  edge : R_TRIG;
  was, stuck : BOOL;
  last : TIME;
END_VAR
edge(CLK := switch);
IF edge.Q THEN presses := presses + 1; END_IF
hold(IN := switch, PT := T#200ms);
lamp := hold.Q;
{bug}
END_PROGRAM
"""
RACE = """
IF NOT switch AND was AND last > T#150ms AND last < T#170ms THEN stuck := TRUE; END_IF
was := switch;
last := hold.ET;
lamp := lamp OR stuck;
"""
"""A switch that opens in a window of 20 ms lights the lamp."""
HISTORY = "IF presses >= 3 THEN lamp := TRUE; END_IF"
"""The third press leaves the lamp on."""
PLAN = """\
rig: rig.yaml
after: 500ms
for: 2s
steps:
- {at: 100ms, set: {wires/switch.on: true}}
- {at: 600ms, set: {wires/switch.on: false}}
properties:
  the lamp goes out: {never: wires/lamp.on and not wires/switch.on, longer: 50ms}
vary:
- {set: {wires/switch.on: false}}
- {press: {wires/switch.on: true}, hold: 50ms}
states: [terminal/presses, wires/lamp.on]
"""

SHORT = PLAN.replace("for: 2s", "for: 800ms").replace("- {press: {wires/switch.on: true}, hold: 50ms}\n", "")
"""A plan for sweeps, which try every instant."""


TWO_BUGS = """
IF NOT switch AND was AND last > T#150ms AND last < T#170ms THEN stuck := TRUE; END_IF
IF presses >= 2 THEN
  lamp := TRUE;
END_IF
was := switch;
last := hold.ET;
lamp := lamp OR stuck;
"""
"""A race, and a counter, behind the same property."""


def planted(folder: Path, bug: str, plan: str = PLAN) -> Path:
    (folder / "rig.yaml").write_text(LAMP_RIG)
    (folder / "lamp.st").write_text(PROGRAM.format(bug=bug))
    (folder / "plan.yaml").write_text(plan)
    return folder / "plan.yaml"


def searched(
    plan_file: Path,
    *strategies: str,
    most: int = 10_000,
    seed: int = 1,
    shard: Shard = WHOLE,
    workers: int = 2,
    is_first: bool = False,
) -> tuple[Corpus, list[str]]:
    plan, corpus, told = load_plan(plan_file), Corpus(None), list[str]()
    with Bench(plan) as bench, LocalCrew(bench, workers) as crew:
        Search(plan, bench, crew, corpus, seed, shard).go(
            strategies, Limits(600.0, most, is_first=is_first), told.append
        )
    return corpus, told
