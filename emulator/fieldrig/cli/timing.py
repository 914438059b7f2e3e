"""The commands `step`, `back`, `pause` and `run` of a rig with `time: virtual`, and `stop` and `restart` of any rig."""

from typing import Annotated, Any

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import AsJson, Endpoint, argument, duration_ns, echo_json
from fieldrig.outside.addresses import DEFAULT_ENDPOINT

PATIENCE_S = 3600.0
"""Time limit for an answer, in seconds, as virtual hours may take long."""


def step(
    duration: Annotated[
        str, typer.Argument(metavar="[DURATION]", help="Virtual time to advance, such as 10ms or 1s.")
    ] = "1ms",
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Advance a rig in virtual time, and pause it.

    \b
        fieldrig step 10ms
        fieldrig step 1.5s
        fieldrig step 0s          pause without advancing
    """
    _tell(endpoint, "step", {"ns": duration_ns(duration)}, as_json)


def back(
    instant: Annotated[
        str, typer.Argument(metavar="TIME", help="The instant of virtual time to go back to, such as 12.34s.")
    ],
    by: Annotated[bool, typer.Option("--by", help="Go back by this time, instead of to it.")] = False,
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Go back in a rig in virtual time, and pause it.

    Programs, drives, buses, plants and random numbers are as they were when the clock came to this instant. What came
    after it has never been; `fieldrig run` goes on from there.

    \b
        fieldrig back 12.34s
        fieldrig back --by 500ms
    """
    from fieldrig.control.messages import Client

    instant_ns = duration_ns(instant)
    if by:
        with Client(endpoint) as client:
            instant_ns = max(int(client.ask("rig/status").get("now_ns", 0)) - instant_ns, 0)
    _tell(endpoint, "back", {"ns": instant_ns}, as_json)


def pause(as_json: AsJson = False, endpoint: Endpoint = DEFAULT_ENDPOINT) -> None:
    """Pause a rig in virtual time; `fieldrig run` resumes it."""
    _tell(endpoint, "pause", None, as_json)


def run(
    speed: Annotated[
        str | None,
        argument("[SPEED]", "Virtual seconds per second, or max.  [default: the speed before the pause]"),
    ] = None,
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Resume a rig in virtual time.

    \b
        fieldrig run            at the speed before the pause
        fieldrig run 10         ten times as fast as real time
        fieldrig run max        as fast as the host can
    """
    _tell(endpoint, "run", None if speed is None else {"speed": _speed(speed)}, as_json)


def stop(endpoint: Endpoint = DEFAULT_ENDPOINT) -> None:
    """Stop a running rig in order, as Ctrl-C does in its terminal."""
    from fieldrig.control.messages import Client

    with Client(endpoint) as client:
        rig = client.ask("rig/status")
        client.ask("rig/stop")
    typer.echo(f"{rig['rig']} stops ({rig['file']}, process {rig['pid']})")


def restart(
    name: Annotated[
        str,
        argument("NAME", "The device; in real time a bus or a process too.", completion.part),
    ],
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Switch a device off and on at one instant; it keeps its non-volatile memory and its faults.

    In real time, the name of a bus or a process starts that process again, as does a device that hangs. `fieldrig
    fault io power_off` leaves a device without power for a while.

    \b
        fieldrig restart io
    """
    from fieldrig.control.messages import Client

    with Client(endpoint) as client:
        client.ask("rig/restart", {"name": name})


def _speed(text: str) -> float | None:
    try:
        speed = None if text == "max" else float(text)
    except ValueError:
        speed = 0.0
    if speed is not None and not speed > 0:
        raise typer.BadParameter(f"{text!r} is not a speed; expected a number above 0, or max")
    return speed


def _tell(endpoint: str, verb: str, message: Any, as_json: bool) -> None:
    from fieldrig.control.messages import Client

    with Client(endpoint) as client:
        answer = client.ask(f"rig/{verb}", message, PATIENCE_S)
    if as_json:
        echo_json(answer)
    else:
        typer.echo(f"{answer['now_ns'] / 1e9:.9f} s, {'paused' if answer['is_paused'] else 'running'}")
