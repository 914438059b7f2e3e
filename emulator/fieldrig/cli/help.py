"""The command `help`: a command explained, or all lines that reach a bus or device of the running rig."""

from typing import Annotated, Any

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import AsJson, Endpoint, argument, echo_json
from fieldrig.cli.names import Parts, check_name
from fieldrig.cli.width import output_width
from fieldrig.outside.addresses import DEFAULT_ENDPOINT
from fieldrig.text.listed import listed


def help_(
    context: typer.Context,
    names: Annotated[
        list[str] | None,
        argument("[NAME]...", "A bus or device of the running rig, or a command.", completion.part),
    ] = None,
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Show how to reach a bus or device of the running rig from outside, or the help of a command.

    \b
        fieldrig help can0              the connections of a bus, and commands to copy
        fieldrig help drive             commands that read and write the registers of a device
        fieldrig help trace record      the same as fieldrig trace record --help
    """
    root: Any = context.find_root().command
    words = names or []
    if not words or root.get_command(context.find_root(), words[0]) is not None:
        root.main([*words, "--help"], prog_name="fieldrig")
    if len(words) > 1:
        raise typer.BadParameter(f"{' '.join(words)!r} is no command; expected a command, or one bus or device")
    answer = _ask(endpoint, words[0])
    if as_json:
        echo_json(answer)
    else:
        _show(answer, endpoint)


def _ask(endpoint: str, name: str) -> dict[str, Any]:
    from fieldrig.control.messages import Client

    with Client(endpoint) as client:
        parts = Parts(client)
        check_name(name, [*parts.buses, *parts.devices], f"{parts.rig} has no bus or device")
        answer: dict[str, Any] = client.ask(f"help/{name}")
    return answer


def _show(answer: dict[str, Any], control: str) -> None:
    from fieldrig.cli.reach import PACKAGES, as_typed, missing_program

    line = f"{answer['name']}: {answer['kind']}"
    if linked := answer["linked"]:
        line += " on " if answer["sort"] == "device" else " with "
        line += listed(linked, output_width() - len(line))
    typer.echo(line)
    for connection in answer["connections"]:
        typer.echo(f"  {connection['protocol']} at {as_typed(connection['address'], control)}")
    missing = dict[str, int]()
    for tool in answer["tools"]:
        program = missing_program(tool["line"])
        if program is not None:
            missing[program] = missing.get(program, 0) + 1
            continue
        typer.echo(f"\n  {tool['label']}\n      {as_typed(tool['line'], control)}")
    if answer["sort"] == "bus" and answer["linked"]:
        typer.echo(f"\n  each device has commands of its own, such as `fieldrig help {answer['linked'][0]}`")
    for program, count in missing.items():
        lines = "1 more line" if count == 1 else f"{count} more lines"
        typer.echo(
            f"\n  {lines} for {program}, which is not installed; on Debian: sudo apt-get install {PACKAGES[program]}"
        )
