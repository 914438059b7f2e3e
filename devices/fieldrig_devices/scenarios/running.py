"""Runs a scenario file in virtual time."""

from collections.abc import Sequence
from pathlib import Path

from fieldrig.config.rig_file import load
from fieldrig.errors import UnmetError
from fieldrig.system.stopwatch import Stopwatch
from fieldrig.virtual.rig import Rig
from fieldrig_devices.scenarios.play import play
from fieldrig_devices.scenarios.report import Outcome, told
from fieldrig_devices.scenarios.scenario_file import load_scenario


def run_scenario(file: str | Path, *overrides: str) -> Outcome:
    """Play a scenario file, with overrides of its rig such as "seed=3".  UnmetError if a property does not hold."""
    outcome = played(Path(file), overrides)
    for violation in outcome.played.violations[:1]:
        what, *others = told(outcome.played, violation)
        raise UnmetError(f"{violation.property}: {what}", "\n".join(others))
    return outcome


def played(file: Path, overrides: Sequence[str] = ()) -> Outcome:
    """Play a scenario file, and return its outcome, whatever it is."""
    watch, scenario = Stopwatch(), load_scenario(file)
    with Rig(load(scenario.rig, ("time=virtual", *scenario.overrides, *overrides))) as rig:
        rig.run_until(scenario.after_ns)
        shown = play(rig, scenario.schedule, scenario.properties, scenario.length_ns, recovery=scenario.recovery)
    return Outcome(file, scenario, shown, watch.seconds)
