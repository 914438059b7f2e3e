"""Commands on the time of a rig with `time: virtual`, and on the rig as a whole: step, pause, run, stop, restart."""

from typing import Annotated, Any

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import DEFAULT_ENDPOINT, AsJson, Endpoint, duration_ns, echo_json

PATIENCE_S = 3600.0
"""Virtual hours may take their time."""


def step(
    duration: Annotated[str, typer.Argument(help="How far, such as 10ms or 1s.")] = "1ms",
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Move a rig in virtual time on by a duration, and pause it there.

    \b
        fieldrig step 10ms
        fieldrig step 1.5s
        fieldrig step 0s          only pause
    """
    _tell(endpoint, "step", {"ns": duration_ns(duration)}, as_json)


def pause(as_json: AsJson = False, endpoint: Endpoint = DEFAULT_ENDPOINT) -> None:
    """Stop the time of a rig in virtual time; `fieldrig run` goes on."""
    _tell(endpoint, "pause", None, as_json)


def run(
    speed: Annotated[
        str | None, typer.Argument(help="Virtual seconds per second, or max; without it as before.", show_default=False)
    ] = None,
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Let a rig in virtual time run on.

    \b
        fieldrig run            as before the pause
        fieldrig run 10         ten times as fast as the clock on the wall
        fieldrig run max        as fast as the computer can
    """
    _tell(endpoint, "run", None if speed is None else {"speed": _speed(speed)}, as_json)


def stop(endpoint: Endpoint = DEFAULT_ENDPOINT) -> None:
    """End a running rig in order, as Ctrl-C does where it runs."""
    from fieldrig.control import Client

    with Client(endpoint) as client:
        rig = client.ask("rig/status")
        client.ask("rig/stop")
    typer.echo(f"{rig['rig']} stops ({rig['file']}, process {rig['pid']})")


def restart(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            help="A process, or a device or bus in it.",
            show_default=False,
            autocompletion=completion.part,
        ),
    ],
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """End one process of a rig in real time and start it again, as a power cycle of its devices.

    \b
        fieldrig restart io
    """
    from fieldrig.control import Client

    with Client(endpoint) as client:
        client.ask("rig/restart", {"name": name})


def _speed(text: str) -> float | None:
    try:
        speed = None if text == "max" else float(text)
    except ValueError:
        speed = 0.0
    if speed is not None and not speed > 0:
        raise typer.BadParameter(f"{text!r} is not a speed: write a number above 0, or max")
    return speed


def _tell(endpoint: str, verb: str, message: Any, as_json: bool) -> None:
    from fieldrig.control import Client

    with Client(endpoint) as client:
        answer = client.ask(f"rig/{verb}", message, PATIENCE_S)
    if as_json:
        echo_json(answer)
    else:
        typer.echo(f"{answer['now_ns'] / 1e9:.9f} s, {'paused' if answer['is_paused'] else 'running'}")
