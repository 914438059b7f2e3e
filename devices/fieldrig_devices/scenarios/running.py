"""Runs a scenario file in virtual time."""

from collections.abc import Sequence
from pathlib import Path

from fieldrig.config.rig_file import RigConfig, load
from fieldrig.errors import ConfigError, RigError, UnmetError
from fieldrig.system.stopwatch import Stopwatch
from fieldrig.virtual.rig import Rig
from fieldrig_devices.scenarios.checks import check
from fieldrig_devices.scenarios.play import play
from fieldrig_devices.scenarios.report import Outcome, told
from fieldrig_devices.scenarios.scenario_file import Scenario, load_scenario


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
    with Rig(config_of(scenario, overrides)) as rig:
        rig.run_until(scenario.after_ns)
        check(rig, scenario)
        try:
            shown = play(rig, scenario.schedule, scenario.properties, scenario.length_ns, recovery=scenario.recovery)
        except ConfigError:
            raise
        except RigError as wrong:
            raise type(wrong)(f"{file}: {wrong.what}", wrong.remedy) from wrong
    return Outcome(file, scenario, shown, watch.seconds)


def check_file(file: Path, overrides: Sequence[str] = ()) -> None:
    """Check a scenario file with its rig.  ConfigError with every mistake.

    The rig runs only if it does not have everything at once, as some programs take a while until their variables are
    there.
    """
    scenario = load_scenario(file)
    with Rig(config_of(scenario, overrides)) as rig:
        try:
            check(rig, scenario)
        except ConfigError:
            if not scenario.after_ns:
                raise
            rig.run_until(scenario.after_ns)
            check(rig, scenario)


def config_of(scenario: Scenario, overrides: Sequence[str]) -> RigConfig:
    """Return the rig of a scenario in virtual time.  ConfigError with its mistakes."""
    return load(scenario.rig, ("time=virtual", *scenario.overrides, *overrides))
