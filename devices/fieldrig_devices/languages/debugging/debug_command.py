"""The command `fieldrig debug`: a debugger for the program of a device in a running rig, also in scripts."""

from collections.abc import Iterator
from typing import Annotated, Final

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import Endpoint, argument
from fieldrig.outside.addresses import DEFAULT_ENDPOINT

SECTION = "Programs"
"""The group of the command in the help of `fieldrig`."""
PROMPT: Final = "(debug) "
NS_PER_S: Final = 1_000_000_000

DeviceName = Annotated[
    str,
    argument(
        "DEVICE|FILE",
        "A device of the running rig whose program is debugged, or a scenario file, such as a finding of a search.",
        completion.ready_part,
    ),
]


def debug(
    device: DeviceName,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
    program: Annotated[
        str | None,
        typer.Option("--device", metavar="NAME", help="With a file: the device to debug.", show_default=False),
    ] = None,
) -> None:
    """Debug the program of a device in a running rig: breakpoints, steps, values, forcing, and traces.

    \b
        fieldrig debug controller
        printf 'break 12\\nrun\\nwhere\\nprint Main.count\\n' | fieldrig debug controller
        fieldrig debug found/finding-1.yaml

    It is the same for all languages; `help` at the prompt explains the commands. Commands from a file or a pipe are
    echoed. The first one that fails ends the session, with exit code 6 if the device refused it or the program did not
    stop within 30 s, else 2.

    With a scenario file it plays the scenario to its rig, up to where a property does not hold.
    """
    from fieldrig.testing import free_port
    from fieldrig_devices.languages.debugging.opened import SUFFIXES, opened

    if not device.endswith(SUFFIXES):
        _session(device, endpoint)
        return
    with opened(device, program, f"tcp/127.0.0.1:{free_port()}", moments) as rig:
        for line in rig.told:
            typer.echo(line)
        _session(rig.device, rig.endpoint, is_held=True)


def _session(device: str, endpoint: str, *, is_held: bool = False) -> None:
    """Debug until the user leaves; the rig is paused if it `is_held`."""
    from fieldrig.control.messages import Client
    from fieldrig.errors import ControlError
    from fieldrig_devices.languages.debugging.debugger import Debugger
    from fieldrig_devices.languages.debugging.prompt import SCRIPT_LIMIT_S, converse, is_script
    from fieldrig_devices.languages.debugging.questions import asker, recorder_of, settled, travel_of
    from fieldrig_devices.languages.debugging.traces import with_traces

    with (
        Client(endpoint) as client,
        with_traces(asker(client, device), recorder_of(client, endpoint, device)) as ask,
    ):
        state = settled(ask, moments(None), _quietly)
        travel = travel_of(client, device, ask)
        if is_held:
            travel.hold()
        debugger = Debugger(ask, typer.echo, moments, SCRIPT_LIMIT_S if is_script() else None, travel)
        typer.echo(f"{device}, {state['language']}; `help` explains the commands")
        debugger.begin()
        converse(debugger, PROMPT, (ControlError,))


def _quietly(_progress: str) -> None:
    """The work before a session needs no words."""


def moments(limit_s: float | None) -> Iterator[object]:
    """Yield about 50 times a second, until the limit."""
    from fieldrig.loop.pacing import elapsed_ns

    return elapsed_ns(1.0, None if limit_s is None else round(limit_s * NS_PER_S))
