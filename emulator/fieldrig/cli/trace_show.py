"""The command `trace show`."""

import time

import typer

from fieldrig.cli.common import AsJson, echo_json
from fieldrig.cli.message_words import OfRig, shower_of
from fieldrig.cli.trace_reading import Buses, During, From, Messages, TraceFile
from fieldrig.clock import S
from fieldrig.text.digits import with_fewer_digits


def show(
    file: TraceFile,
    buses: Buses = None,
    rig: OfRig = None,
    begin: From = None,
    duration: During = None,
    as_json: AsJson = False,
) -> None:
    """Print a trace, one line for each message.

    \b
        fieldrig trace show lab.jsonl
        fieldrig trace show lab.pcapng can0
        fieldrig trace show night.blf --from 12.3s --for 1s
        fieldrig trace show lab.jsonl --rig lab.yaml
        candump -L can0 > x.log; fieldrig trace show x.log
    """
    from fieldrig.traces.order import in_order

    shower = shower_of(rig)
    messages = Messages(file, buses, begin=begin, duration=duration)
    for entry in in_order(messages):
        if as_json:
            echo_json(
                {
                    "time_ns": entry.time_ns,
                    "bus": entry.bus,
                    "family": entry.family,
                    "sender": entry.sender,
                    "data": entry.data.hex(),
                    "message": shower(entry),
                }
            )
        else:
            message = with_fewer_digits(shower(entry))
            typer.echo(f"{_instant(entry.time_ns)}  {entry.bus:8}  {entry.sender or '-':12}  {message}")
    messages.tell_oddities()


def _instant(time_ns: int) -> str:
    """Return the time of day, or seconds for virtual time, which starts at 0."""
    from fieldrig.traces.trace import is_time_of_day

    seconds, fraction_ns = divmod(time_ns, S)
    if not is_time_of_day(time_ns):
        return f"{seconds:8}.{fraction_ns // 1000:06}"
    return f"{time.strftime('%H:%M:%S', time.localtime(seconds))}.{fraction_ns // 1000:06}"
