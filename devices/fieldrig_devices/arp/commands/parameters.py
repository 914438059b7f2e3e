"""The commands `fieldrig arp params`, for parameters of a card in RAM and in flash."""

from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import AsJson, command_group, echo_json, echo_table, wrong_usage
from fieldrig_devices.arp.commands.card import Baud, Card, Port, Rig, opened, optional

if TYPE_CHECKING:
    from fieldrig_devices.arp.user_port.client import ArpPort

app = command_group()


@app.callback()
def params() -> None:
    """Read, write and save parameters: @Par[1] is PAR.1 here, and @Par1[7] is PAR1.7.

    A card uses the copies in RAM. It loads them from flash at every start and reset, and its program changes the copies
    in RAM only.

    \b
        fieldrig arp params read PAR1
        fieldrig arp params write PAR1.7=2000
        fieldrig arp params save
    """


@app.command()
def read(
    group: Annotated[str | None, optional("[PAR|PAR1|PAR2]", "Group to show.", "all groups")] = None,
    port: Port = None,
    rig: Rig = None,
    card: Card = None,
    baud: Baud = None,
    as_json: AsJson = False,
) -> None:
    """Show parameters in RAM and in flash."""
    from fieldrig_devices.arp import fixed
    from fieldrig_devices.arp.parameters import PARAMETERS

    known = ("PAR", "PAR1", "PAR2")
    if group is not None and group.upper().lstrip("@") not in known:
        raise typer.BadParameter(f"there is no group {group!r}; expected one of {', '.join(known)}")
    groups = range(3) if group is None else [known.index(group.upper().lstrip("@"))]
    with opened(port, rig, card, baud) as arp_port:
        tables = {number: _both(arp_port, number) for number in groups}
    if as_json:
        echo_json(
            {_name(at, number): {"ram": ram / 1000, "flash": flash / 1000} for at, number, ram, flash in _rows(tables)}
        )
        return
    echo_table(
        ("parameter", "RAM", "flash", "unit", "what"),
        (
            (
                _name(at, number),
                fixed.to_text(ram),
                fixed.to_text(flash) if flash != ram else "same",
                PARAMETERS[at][number].unit,
                PARAMETERS[at][number].name,
            )
            for at, number, ram, flash in _rows(tables)
        ),
    )


@app.command()
def write(
    values: Annotated[
        list[str], typer.Argument(metavar="NAME=VALUE...", help="Parameters and their new values.", show_default=False)
    ],
    flash: Annotated[bool, typer.Option("--flash", help="Write to flash too, to make the change permanent.")] = False,
    port: Port = None,
    rig: Rig = None,
    card: Card = None,
    baud: Baud = None,
) -> None:
    """Change parameters, in RAM until the next reset, or permanently.

    \b
        fieldrig arp params write PAR1.11=3 PAR1.12=0.5
        fieldrig arp params write PAR.1=1 --flash       @Par[1] applies from the next start
    """
    from fieldrig_devices.arp.user_port import quantities
    from fieldrig_devices.arp.user_port.memory import FLASH, RAM

    with wrong_usage():
        pairs = [quantities.assigned(text) for text in values]
        for quantity, _ in pairs:
            if quantity.kind not in quantities.GROUPS:
                raise ValueError(f"{quantities.name_of(quantity)} is not a parameter\nexpected PAR.1 to PAR2.25")
    with opened(port, rig, card, baud) as arp_port:
        for quantity, raw in pairs:
            arp_port.set_parameter(FLASH if flash else RAM, quantities.GROUPS[quantity.kind], quantity.number, raw)
            typer.echo(
                f"{quantities.name_of(quantity)} = {quantities.text_of(quantity, raw)}{' in flash' if flash else ''}"
            )


@app.command()
def save(port: Port = None, rig: Rig = None, card: Card = None, baud: Baud = None) -> None:
    """Copy the parameters that differ from RAM to flash."""
    from fieldrig_devices.arp import fixed
    from fieldrig_devices.arp.user_port.memory import FLASH

    count = 0
    with opened(port, rig, card, baud) as arp_port:
        for at, number, ram, flash in _rows({group: _both(arp_port, group) for group in range(3)}):
            if ram != flash:
                arp_port.set_parameter(FLASH, at, number, ram)
                typer.echo(f"{_name(at, number)} = {fixed.to_text(ram)} in flash, was {fixed.to_text(flash)}")
                count += 1
    typer.echo(f"{count} {'parameter' if count == 1 else 'parameters'} saved")


Tables = dict[int, tuple[list[int], list[int]]]
"""Values in RAM and in flash, by group."""


def _both(card: "ArpPort", group: int) -> tuple[list[int], list[int]]:
    from fieldrig_devices.arp.user_port.memory import FLASH, RAM

    return card.parameters(RAM, group), card.parameters(FLASH, group)


def _rows(tables: Tables) -> list[tuple[int, int, int, int]]:
    """Rows of group, number, value in RAM, and value in flash."""
    return [
        (group, number, pair[0], pair[1])
        for group, (ram, flash) in tables.items()
        for number, pair in enumerate(zip(ram, flash, strict=True))
        if number
    ]


def _name(group: int, number: int) -> str:
    return f"@PAR{group or ''}[{number}]"
