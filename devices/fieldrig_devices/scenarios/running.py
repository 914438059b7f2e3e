"""Runs a scenario in virtual time, or in real time."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from fieldrig.config.rig_file import load
from fieldrig.errors import ConfigError, RigError, UnmetError
from fieldrig.system.stopwatch import Stopwatch
from fieldrig.virtual.rig import Rig
from fieldrig_devices.scenarios.act import RefusedActError
from fieldrig_devices.scenarios.checks import check, refused_at
from fieldrig_devices.scenarios.play import play
from fieldrig_devices.scenarios.report import Outcome, failures
from fieldrig_devices.scenarios.rig_of_scenario import config_of
from fieldrig_devices.scenarios.scenario_file import Scenario, load_scenario
from fieldrig_devices.scenarios.tracing import Trace, heard_by, traced
from fieldrig_devices.scenarios.watching import Played

if TYPE_CHECKING:
    from fieldrig.real.live_rig import LiveRig

_TIME: Final = "time="


def run_scenario(file: str | Path, *overrides: str) -> Outcome:
    """Play a scenario file, with overrides of its rig such as "seed=3".  UnmetError if a property does not hold.

    With "time=real" the rig runs in real time.
    """
    outcome = played(Path(file), overrides)
    wrong = failures(outcome)
    if wrong:
        raise UnmetError(*wrong[0])
    return outcome


def played(file: Path, overrides: Sequence[str] = (), trace_file: Path | None = None) -> Outcome:
    """Play a scenario file, and return its outcome, whatever it is; with the messages in a file if one is given."""
    watch, scenario = Stopwatch(), load_scenario(file)
    try:
        with traced(trace_file) as trace:
            shown = played_of(scenario, overrides, trace)
    except ConfigError:
        raise
    except RefusedActError as wrong:
        raise refused_at(scenario, wrong) from wrong
    except RigError as wrong:
        raise type(wrong)(f"{file}: {wrong.what}", wrong.remedy) from wrong
    return Outcome(file, scenario, shown, watch.seconds)


def played_of(scenario: Scenario, overrides: Sequence[str] = (), trace: Trace | None = None) -> Played:
    """Play a scenario in the time that the overrides choose, which is virtual if they do not."""
    every = (*scenario.overrides, *overrides)
    wanted = [word.removeprefix(_TIME) for word in every if word.startswith(_TIME)]
    if wanted and wanted[-1] == "real":
        return _in_real_time(scenario, every, trace)
    with Rig(config_of(scenario, overrides)) as rig:
        rig.run_until(scenario.after_ns)
        with heard_by(rig, trace):
            return played_virtual(rig, scenario)


def played_virtual(rig: Rig, scenario: Scenario) -> Played:
    """Play a scenario to a rig in virtual time, from the present instant on.  ConfigError for what it does not have."""
    check(rig, scenario)
    if scenario.master is not None:
        return _with_master(rig, scenario, scenario.master)
    return play(
        rig,
        scenario.schedule,
        scenario.properties,
        scenario.length_ns,
        recovery=scenario.recovery,
        forgives=scenario.forgives,
    )


def _with_master(rig: Rig, scenario: Scenario, master: Path) -> Played:
    from fieldrig_devices.scenarios.with_master import MasterStage  # few scenarios have a master

    with (
        MasterStage(
            rig, scenario.schedule, scenario.properties, recovery=scenario.recovery, forgives=scenario.forgives
        ) as stage,
        stage.acting(master, scenario.jitter_ns),
    ):
        return stage.finish(scenario.length_ns)


def played_live(rig: "LiveRig", scenario: Scenario, trace: Trace | None = None) -> Played:
    """Play a scenario to a rig in real time, from now on."""
    from fieldrig.real.running_rig import RunningRig  # virtual time needs no sessions
    from fieldrig_devices.scenarios.live import LiveStage

    with RunningRig(rig.endpoint) as asked:
        status = asked.status()
        config = load(Path(status["file"]), status["overrides"])
        with LiveStage(asked, config, scenario.schedule, scenario.properties, scenario.recovery, trace) as stage:
            return stage.finish(scenario.length_ns)


def check_file(file: Path, overrides: Sequence[str] = ()) -> None:
    """Check a scenario file with its rig.  ConfigError with every mistake."""
    check_scenario(load_scenario(file), overrides)


def check_scenario(scenario: Scenario, overrides: Sequence[str] = ()) -> None:
    """Check a scenario with its rig in virtual time.  ConfigError with every mistake.

    The rig runs only if it does not have everything at once, as some programs take a while until their variables are
    there.
    """
    with Rig(config_of(scenario, overrides)) as rig:
        try:
            check(rig, scenario)
        except ConfigError:
            if not scenario.after_ns:
                raise
            rig.run_until(scenario.after_ns)
            check(rig, scenario)


def _in_real_time(scenario: Scenario, overrides: Sequence[str], trace: Trace | None) -> Played:
    """Play a scenario to the rig that runs, or to one that is started for it."""
    from fieldrig.real.running_rig import running  # virtual time needs no sessions

    check_scenario(scenario, overrides)
    with running(config_of(scenario, overrides, "real")) as rig:
        rig.wait_for_uptime(scenario.after_ns)
        return played_live(rig, scenario, trace)
