"""The commands `get` and `set`: points of devices."""

from math import isfinite
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import AsJson, Endpoint, argument, assignment, echo_json
from fieldrig.cli.names import Parts, check_name
from fieldrig.outside.addresses import DEFAULT_ENDPOINT
from fieldrig.text.digits import show_with_unit

if TYPE_CHECKING:
    from fieldrig.device import Value
    from fieldrig.errors import ControlError


def get(
    names: Annotated[list[str], argument("DEVICE[/KEY]...", "Devices, or single points of them.", completion.point)],
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Read values of devices.

    \b
        fieldrig get tank                     all points of the device
        fieldrig get tank/level io/6200:01    single points
        fieldrig get tank --json              {"tank/level": 0.5, ...}, with all digits

    Errors are reported after the values that could be read, and the exit code is then 6.
    """
    from fieldrig.control.messages import Client
    from fieldrig.errors import ControlError

    values: dict[str, Any] = {}
    facts: dict[str, Any] = {}
    refusals: list[ControlError] = []
    with Client(endpoint) as client:
        parts = Parts(client)
        for name in names:
            device, _, key = name.partition("/")
            try:
                got = parts.ask_device(device, "get", {"keys": [key]} if key else None)
                values |= {f"{device}/{key}": value for key, value in got.items()}
                facts |= _facts(parts, device)
            except ControlError as refusal:
                refusals.append(refusal)
    _echo(values, facts, as_json)
    if refusals:
        raise refusals[0] if len(refusals) == 1 else ControlError("; ".join(map(_in_a_line, refusals)))


def set_(
    settings: Annotated[list[str], argument("DEVICE/KEY=VALUE...", "Points and their new values.", completion.setting)],
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Write values of devices, and print the new values.

    \b
        fieldrig set io/6200:01=0xFF
        fieldrig set tank/level=1.25 drive/run=true
    """
    from fieldrig.control.messages import Client
    from fieldrig.points.values import parse_value

    wanted: dict[str, dict[str, Any]] = {}
    for setting in settings:
        name, text = assignment(setting, "tank/level=1.25")
        device, slash, key = name.partition("/")
        if not slash or not key:
            raise typer.BadParameter(f"{name!r} is not a point; expected DEVICE/KEY, such as tank/level")
        wanted.setdefault(device, {})[key] = _sendable(name, parse_value(text))
    values: dict[str, Any] = {}
    with Client(endpoint) as client:
        parts = Parts(client)
        for device in wanted:  # before anything is written
            check_name(device, parts.devices, f"{parts.rig} has no device")
        for device, device_values in wanted.items() if len(wanted) > 1 else ():
            parts.ask_device(device, "get", {"keys": list(device_values)})
        for device, device_values in wanted.items():
            got = parts.ask_device(device, "set", {"values": device_values})
            values |= {f"{device}/{key}": value for key, value in got.items()}
        facts = {key: fact for device in wanted for key, fact in _facts(parts, device).items()}
    _echo(values, facts, as_json)


def _sendable(name: str, value: "Value") -> "Value":
    """Return the value.  typer.BadParameter for a number that no question to a rig can hold."""
    from fieldrig.outside.untrusted import WIDEST

    if isinstance(value, float) and not isfinite(value):
        raise typer.BadParameter(f"{name} cannot be {value}; expected a finite number")
    if isinstance(value, int) and not WIDEST[0] <= value <= WIDEST[1]:
        raise typer.BadParameter(f"{name} cannot be a number of more than 64 bits")
    return value


def _in_a_line(refusal: "ControlError") -> str:
    return f"{refusal.what} ({refusal.remedy})" if refusal.remedy else refusal.what


def _facts(parts: Parts, device: str) -> dict[str, Any]:
    return {f"{device}/{key}": fact for key, fact in parts.ask_device(device, "keys").items()}


def _echo(values: dict[str, Any], facts: dict[str, Any], as_json: bool) -> None:
    """Print the values with the words about a late host beside them; JSON has values only, so they go to stderr."""
    if as_json:
        echo_json(values)
        for name in values:
            if words := facts.get(name, {}).get("host"):
                typer.echo(f"note: {name}: {words}", err=True)
        return
    for name, value in values.items():
        fact = facts.get(name, {})
        unit = fact.get("unit", "")
        line = f"{name} = {show_with_unit(value, unit)}"
        typer.echo(f"{line} ({fact['host']})" if fact.get("host") else line)
