"""The commands `get` and `set`: points of devices."""

from typing import Annotated, Any

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import AsJson, Endpoint, argument, assignment, echo_json
from fieldrig.net import DEFAULT_ENDPOINT


def get(
    names: Annotated[list[str], argument("DEVICE[/KEY]...", "Devices, or single points of them.", completion.point)],
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Read values of devices.

    \b
        fieldrig get tank                     all points of the device
        fieldrig get tank/level io/6200:01    single points
        fieldrig get tank --json              {"tank/level": 0.5, ...}

    Errors are reported after the values that could be read, and the exit code is then 6.
    """
    from fieldrig.control import Client
    from fieldrig.errors import ControlError

    values: dict[str, Any] = {}
    units: dict[str, str] = {}
    refusals: list[ControlError] = []
    with Client(endpoint) as client:
        for name in names:
            device, _, key = name.partition("/")
            try:
                got = _ask(client, device, "get", {"keys": [key]} if key else None)
                values |= {f"{device}/{key}": value for key, value in got.items()}
                units |= {} if as_json else _units(client, device)
            except ControlError as refusal:
                refusals.append(refusal)
    _echo(values, units, as_json)
    if refusals:
        raise refusals[0] if len(refusals) == 1 else ControlError("; ".join(refusal.what for refusal in refusals))


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
    from fieldrig.control import Client
    from fieldrig.values import parse_value

    wanted: dict[str, dict[str, Any]] = {}
    for setting in settings:
        name, text = assignment(setting, "tank/level=1.25")
        device, slash, key = name.partition("/")
        if not slash or not key:
            raise typer.BadParameter(f"{name!r} is not a point; expected DEVICE/KEY, such as tank/level")
        wanted.setdefault(device, {})[key] = parse_value(text)
    values: dict[str, Any] = {}
    with Client(endpoint) as client:
        for device, device_values in wanted.items():
            got = _ask(client, device, "set", {"values": device_values})
            values |= {f"{device}/{key}": value for key, value in got.items()}
        units = {} if as_json else {key: unit for device in wanted for key, unit in _units(client, device).items()}
    _echo(values, units, as_json)


def _units(client: Any, device: str) -> dict[str, str]:
    facts = _ask(client, device, "keys", None)
    return {f"{device}/{key}": fact["unit"] for key, fact in facts.items()}


def _ask(client: Any, device: str, verb: str, message: Any) -> Any:
    """Ask the device, with a helpful message if its process does not answer."""
    from fieldrig.control import NoAnswerError
    from fieldrig.errors import ControlError

    try:
        return client.ask(f"device/{device}/{verb}", message)
    except NoAnswerError:
        status = client.ask("rig/status")
        known = status["devices"]
        if device in known:
            raise ControlError(
                f"{device} does not answer: it has not started, or its process died", "look at `fieldrig status`"
            ) from None
        raise ControlError(
            f"{status['rig']} has no device {device!r}", f"it has: {', '.join(known) or 'none'}"
        ) from None


def _echo(values: dict[str, Any], units: dict[str, str], as_json: bool) -> None:
    if as_json:
        echo_json(values)
        return
    for name, value in values.items():
        typer.echo(f"{name} = {show_value(value)} {units.get(name, '')}".rstrip())


def show_value(value: Any) -> str:
    """Return a value as text, with all its digits."""
    from fieldrig.values import show_number

    if isinstance(value, bool):
        return "true" if value else "false"
    return show_number(value) if isinstance(value, float) else str(value)
