"""`fieldrig scenario`: plays scenarios to their rigs, and says what did not hold."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import (
    AsJson,
    ListenAt,
    Overrides,
    WithoutPage,
    argument,
    command_group,
    echo_json,
    writing,
)
from fieldrig.errors import UsageError
from fieldrig.system.exits import Exit

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldrig_devices.scenarios.report import Outcome

SECTION = "Run a rig"
"""The group of the command in the help of `fieldrig`."""
app = command_group()
Files = Annotated[list[Path], argument("FILE...", "Scenario files; a folder means all .yaml files in it.")]


@app.callback()
def scenario() -> None:
    """Play scenarios: what happens to a rig, and what has to hold meanwhile.

    \b
        fieldrig scenario run configs/scenarios/feeder-trip.yaml
        fieldrig scenario check configs/scenarios
        fieldrig scenario open found/finding-1.yaml
    """


@app.command()
def check(files: Files, overrides: Overrides = None) -> None:
    """Check scenario files and their rigs, and list all mistakes."""
    from fieldrig.errors import ConfigError, Mistake
    from fieldrig_devices.scenarios.running import check_file

    mistakes = list[Mistake]()
    for file in _found(files):
        try:
            check_file(file, overrides or ())
            typer.echo(f"{file}: no mistakes")
        except ConfigError as wrong:
            mistakes += wrong.mistakes
    if mistakes:
        raise ConfigError(mistakes)


@app.command()
def run(
    files: Files,
    overrides: Overrides = None,
    pictures: Annotated[
        Path | None,
        typer.Option(
            "--pictures",
            metavar="FOLDER",
            help="Write a picture of each scenario, and of each property that does not hold.",
            show_default=False,
        ),
    ] = None,
    junit: Annotated[
        Path | None, typer.Option("--junit", metavar="FILE", help="Write a JUnit report.", show_default=False)
    ] = None,
    trace: Annotated[
        Path | None,
        typer.Option(
            "--trace",
            metavar="FILE",
            help="Write the messages of one scenario, as `trace record` does.",
            show_default=False,
        ),
    ] = None,
    real: Annotated[
        bool, typer.Option("--real", help="In real time: to the rig that runs, or else to one that is started for it.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Play scenarios, in virtual time without --real. The exit code is 1 if a property does not hold."""
    from fieldrig_devices.scenarios.report import as_json as outcome_json
    from fieldrig_devices.scenarios.report import junit as junit_of
    from fieldrig_devices.scenarios.report import lines_of
    from fieldrig_devices.scenarios.running import played

    outcomes, found = list["Outcome"](), _found(files)
    if trace is not None and len(found) > 1:
        raise typer.BadParameter("--trace is the file of one scenario; expected one file")
    for file in found:
        outcomes.append(played(file, (*(overrides or ()), *(["time=real"] if real else [])), trace))
        for line in () if as_json else lines_of(outcomes[-1]):
            typer.echo(line)
        if pictures is not None:
            outcomes[-1].write_pictures(pictures)
    if junit is not None:
        with writing(junit):
            junit.write_bytes(junit_of(outcomes))
    if as_json:
        echo_json([outcome_json(one) for one in outcomes])
    if not all(one.is_good for one in outcomes):
        raise typer.Exit(Exit.TESTS_FAILED)


@app.command("open")
def open_there(
    file: Annotated[Path, argument("FILE", "A scenario file, such as a finding of a search.")],
    overrides: Overrides = None,
    control: ListenAt = None,
    no_ui: WithoutPage = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print only problems.")] = False,
) -> None:
    """Play a scenario up to where a property does not hold, and keep its rig there, paused, until Ctrl-C.

    The page of the rig shows the time line. `fieldrig back` and `fieldrig debug` go back from there.
    """
    from fieldrig.cli.running import UpOptions, run_rig
    from fieldrig.config.rig_file import load
    from fieldrig_devices.scenarios.scenario_file import load_scenario
    from fieldrig_devices.scenarios.standing import Standing

    scenario = load_scenario(file)
    if scenario.master is not None:
        what = f"{file}: a rig with a master of Python cannot go back in time"
        raise UsageError(what, "`fieldrig scenario run` plays it, with a picture")
    place = [] if control is None else [f"control={control}"]
    values = ("time=virtual", *scenario.overrides, *(overrides or ()), *place)
    options = UpOptions(values, is_quiet=quiet, has_page=not no_ui)
    raise typer.Exit(run_rig(load(scenario.rig, values), options, Standing(file.name, scenario)))


def _found(files: "Sequence[Path]") -> list[Path]:
    """Return the files, and those in folders.  UsageError for a folder without one."""
    from fieldrig.errors import UsageError

    found = list[Path]()
    for file in files:
        inside = sorted(file.glob("*.yaml")) if file.is_dir() else [file]
        if not inside:
            raise UsageError(f"{file} has no scenario files", "expected files that end in .yaml")
        found += inside
    return found
