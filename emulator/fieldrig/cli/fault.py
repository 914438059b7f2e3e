"""The command `fault`: faults of a bus or a device of a running rig."""

from collections.abc import Mapping
from typing import Annotated, Any

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import AsJson, Endpoint, argument, echo_json, echo_table
from fieldrig.cli.fault_kinds import show_kinds
from fieldrig.control.fault_questions import STANDING, TIMES, in_words
from fieldrig.faults.words import fault_of_words
from fieldrig.outside.addresses import DEFAULT_ENDPOINT


def fault(
    where: Annotated[
        str | None,
        argument("BUS|DEVICE", "A bus or a device of the rig; with --kinds, a kind.", completion.faulty),
    ] = None,
    words: Annotated[
        list[str] | None,
        argument("WHAT|KEY=VALUE", "The fault to add, and its keys.", completion.fault_word),
    ] = None,
    clear: Annotated[
        str | None,
        typer.Option("--clear", metavar="NUMBER", help="Clear the fault of this number, or all.", show_default=False),
    ] = None,
    kinds: Annotated[bool, typer.Option("--kinds", help="List the faults of all kinds, without a rig.")] = False,
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Show, add or clear faults of a bus or a device.

    \b
        fieldrig fault can0
        fieldrig fault can0 drop identifier=0x185 probability=0.1 count=5 duration_ms=2000
        fieldrig fault can0 drop node=sensor receivers='[io]'
        fieldrig fault can0 --clear 1
        fieldrig fault can0 --clear all
        fieldrig fault ring0 break after=belt duration_ms=500
        fieldrig fault io power_off duration_ms=2000
        fieldrig fault --kinds
        fieldrig fault --kinds modbus.tcp

    Adding a fault prints its number. Faults and their keys are the same as under `faults` in a rig file.
    `fieldrig watch BUS` shows each time that one is applied. Faults added here are lost when the process of the bus or
    device restarts.
    """
    from fieldrig.control.fault_asking import about_faults, ask
    from fieldrig.control.messages import Client

    if kinds:
        show_kinds(where, as_json)
        return
    if where is None:
        raise typer.BadParameter("name a bus or a device of the rig, or list all faults by --kinds")
    if words and clear is not None:
        raise typer.BadParameter("either add a fault or clear some, not both at once")
    given, number = _fault(words or []), _number(where, clear)
    with Client(endpoint) as client:
        if given:
            answer = ask(client, about_faults(where, "add_fault", {"fault": given}))
        elif clear is not None:
            answer = ask(client, about_faults(where, "clear_fault", {"number": number}))
        else:
            answer = ask(client, about_faults(where, "faults", None))
    if as_json:
        echo_json(answer)
    elif given:
        typer.echo(answer["number"])
    elif clear is not None:
        typer.echo(f"cleared: {', '.join(map(str, answer['cleared'])) or 'none'}")
    else:
        _show(answer)


def _fault(words: list[str]) -> dict[str, str]:
    """Return the fault; values stay texts, as only the bus knows whether `data=10` is a number."""
    try:
        return fault_of_words(words)
    except ValueError as wrong:
        raise typer.BadParameter(str(wrong)) from wrong


def _number(where: str, clear: str | None) -> int | None:
    if clear is None or clear == "all":
        return None
    try:
        return int(clear)
    except ValueError:
        what = f"{clear!r} is no fault: write a number that `fieldrig fault {where}` shows, or all"
        raise typer.BadParameter(what) from None


def _show(faults: Mapping[str, Mapping[str, Any]]) -> None:
    if not faults:
        typer.echo("none")
        return
    echo_table(
        ("number", "what", "where and how", "when", "state", "applied"),
        [
            (
                number,
                fault["what"],
                in_words(fault, without=(*STANDING, *TIMES)),
                in_words({key: value for key, value in fault.items() if key in TIMES}),
                fault["state"],
                fault["applied"],
            )
            for number, fault in faults.items()
        ],
    )
