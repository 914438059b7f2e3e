"""The commands `check`, `schema` and `devices`, which look at files and kinds and need no running rig."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import AsJson, Overrides, argument, echo_json, echo_table, json_text

if TYPE_CHECKING:
    from fieldrig.config.entries import DeviceEntry
    from fieldrig.config.rig_file import RigConfig
    from fieldrig.errors import Mistake
    from fieldrig.settings import WrongKey


def check(
    files: Annotated[list[Path], argument("FILE...", "The rig files.", completion.rig_file)],
    overrides: Overrides = None,
    as_json: AsJson = False,
) -> None:
    """Check rig files, and explain every mistake.

    \b
    Each mistake is reported with its file, line and key, and with what was expected. Nothing is started.
    Flaws that do not prevent a start, such as those of an EDS file, are warnings.
        fieldrig check configs/lab.yaml
        fieldrig check configs/*.yaml
        fieldrig check configs/lab.yaml --set buses.can0.bitrate=250000
        fieldrig check configs/lab.yaml --json     list the mistakes for an editor or a script
    """
    from dataclasses import asdict

    from fieldrig.errors import ConfigError
    from fieldrig.system.exits import Exit

    mistakes: list[Mistake] = []
    warnings: list[Mistake] = []
    for file in files:
        config, wrong, doubts = look_at(file, overrides or ())
        mistakes += wrong
        warnings += doubts
        if as_json:
            continue
        for doubt in doubts:
            typer.echo(f"warning: {doubt}", err=True)
        if config is not None and not wrong:
            typer.echo(f"{file} has no mistakes: {config.name}, time: {config.time}, {_content(config)}")
    if as_json:
        warned = [{**asdict(doubt), "severity": "warning"} for doubt in dict.fromkeys(warnings)]
        echo_json([*(asdict(mistake) for mistake in dict.fromkeys(mistakes)), *warned])
        raise typer.Exit(Exit.WRONG if mistakes else Exit.OK)
    if mistakes:
        raise ConfigError(list(dict.fromkeys(mistakes)))  # files that extend the same one have its mistakes in common


def look_at(file: Path, overrides: Sequence[str]) -> "tuple[RigConfig | None, list[Mistake], list[Mistake]]":
    """Return the rig of a file, or None if it is wrong; its mistakes and those of its programs; and its doubts."""
    from fieldrig.config.build import try_devices
    from fieldrig.config.near_names import near_names
    from fieldrig.config.rig_file import look_through
    from fieldrig.config.source import gather
    from fieldrig.faults.milestones import wrong_conditions

    config, right, mistakes = look_through(file, overrides)
    source = gather(file, overrides)
    mistakes = [*mistakes, *try_devices(right), *wrong_conditions(source, right)]
    doubts = [_placed(doubt, device) for device in right for doubt in device.settings.doubts()]
    if config is not None:
        doubts += near_names(source, config.buses, config.devices)
    return config, mistakes, list(dict.fromkeys(doubts))


def _placed(doubt: "Mistake | WrongKey", device: "DeviceEntry") -> "Mistake":
    """Return a doubt about a key of this device with its place, the first line of the device."""
    from fieldrig.config.yaml_source import key_text
    from fieldrig.errors import Mistake

    if isinstance(doubt, Mistake):
        return doubt
    return Mistake(*device.place, key_text(("devices", device.name, *doubt.path)), doubt.what, doubt.remedy)


def _content(config: "RigConfig") -> str:
    from fieldrig.points.values import counted
    from fieldrig.real.placement import placement

    counts = [counted(len(config.buses), "bus", "buses"), counted(len(config.devices), "device")]
    if config.time == "real":
        counts.append(counted(len(placement(config)), "process", "processes"))
    return ", ".join(counts)


def schema(
    name: Annotated[
        str,
        typer.Argument(
            metavar="[FILE]", help="Print the schema of this kind of file: rig, register-table or name-plate."
        ),
    ] = "rig",
) -> None:
    """Print the JSON Schema of rig files, for editors.

    \b
        fieldrig schema > fieldrig.schema.json
        fieldrig schema register-table > register-table.schema.json
    Editors with the YAML language server read it if this is the first line of a rig file:
        # yaml-language-server: $schema=fieldrig.schema.json
    """
    from fieldrig.config.schema import schema_of
    from fieldrig.errors import RigError

    try:
        text = json_text(schema_of(name), indent=2)
    except RigError as wrong:
        raise typer.BadParameter(f"{wrong.what}; {wrong.remedy}") from wrong
    typer.echo(text)


def devices(
    kind: Annotated[
        str | None,
        argument("[KIND]", "Show the links and settings of this kind.", completion.kind),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the kinds of buses and devices, or the settings of one.

    \b
        fieldrig devices                  all installed kinds, one line each
        fieldrig devices canopen.node     its links and settings
        fieldrig devices can.hub
        fieldrig devices press:Press      a class of your own, in press.py in this folder
    """
    if kind is None:
        _list_kinds(as_json)
    else:
        _describe(kind, as_json)


def _list_kinds(as_json: bool) -> None:
    from fieldrig.config.kinds import list_buses, list_devices

    if as_json:
        echo_json({"buses": dict(list_buses()), "devices": dict(list_devices())})
        return
    rows = [("device", *kind) for kind in list_devices()] + [("bus", *kind) for kind in list_buses()]
    echo_table(("", "kind", "what it is"), rows)


def _describe(kind: str, as_json: bool) -> None:
    import sys

    from fieldrig.cli.kind_facts import facts_of, without

    sys.path.insert(0, str(Path.cwd()))
    facts = facts_of(kind)
    if as_json:
        echo_json(facts)
        return
    typer.echo(f"{facts['sort']} {kind}: {facts['about']}")
    if facts["links"]:
        typer.echo("\nlinks:")
        echo_table(("name", "a bus of kind", ""), [(name, *words) for name, words in facts["links"].items()])
    if facts["settings"]:
        typer.echo("\nsettings:")
        echo_table(
            ("key", "value", "without it", "what it is"),
            [(key, fact["type"], without(fact), fact["about"]) for key, fact in facts["settings"].items()],
        )
    if facts["faults"]:
        typer.echo("\nfaults, each with start_ms and duration_ms:")
        echo_table(("what", "further keys"), facts["faults"].items())
