"""The command `fieldrig debug-adapter`: a debug adapter for editors on standard input and output."""

import sys
from contextlib import suppress
from typing import Annotated, Final

from fieldrig.cli import completion
from fieldrig.cli.common import Endpoint, argument
from fieldrig.outside.addresses import DEFAULT_ENDPOINT

SECTION = "Programs"
"""The group of the command in the help of `fieldrig`."""
MOMENT_S: Final = 0.1
"""Interval at which the program is looked at, in seconds of real time."""


def debug_adapter(
    device: Annotated[
        str, argument("DEVICE", "A device of the running rig whose program is debugged.", completion.ready_part)
    ],
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Debug a program in a running rig from an editor.

    Speaks the Debug Adapter Protocol on standard input and output, so that an editor starts it as its debug adapter
    with the request `attach`.
    """
    from fieldrig.control.messages import Client
    from fieldrig.errors import ControlError
    from fieldrig.system.stdio_stream import chunks
    from fieldrig.system.this_process import exit_on_signals
    from fieldrig_devices.languages.debugging.adapter import Adapter
    from fieldrig_devices.languages.debugging.prompt import ENDING
    from fieldrig_devices.languages.debugging.questions import asker, recorder_of, travel_of
    from fieldrig_devices.languages.debugging.traces import with_traces

    with (
        Client(endpoint) as client,
        with_traces(asker(client, device), recorder_of(client, endpoint, device)) as ask,
    ):
        adapter = Adapter(ask, travel_of(client, device, ask))
        exit_on_signals(ENDING)
        try:
            for data in chunks(MOMENT_S):
                sys.stdout.buffer.write(adapter.feed(data) + adapter.poll())
                sys.stdout.buffer.flush()
                if adapter.is_over:
                    return
        finally:  # an editor that dies asks for nothing
            with suppress(ControlError):
                adapter.end()
