"""Writes the bytes of an answer that an injected fault has damaged."""

from collections.abc import Callable
from functools import partial

from fieldrig.clock import Clock
from fieldrig_bus.modbus.message import DamagedAnswer


def write_damaged(clock: Clock, write: Callable[[bytes], None], answer: DamagedAnswer) -> None:
    """Write the pieces of an answer, each at its instant."""
    for after_ns, data in answer.pieces:
        if after_ns == 0:
            write(data)
        else:
            clock.call_at(clock.now_ns() + after_ns, partial(write, data))
