"""Storing and restoring parameters.

Source: CiA 301 7.5.2.13 (1010h), 7.5.2.14 (1011h).
"""

from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.line import Steps

STORE, RESTORE = 0x1010, 0x1011
ALL, COMMUNICATION = 1, 2
"""Sub-indices."""
SAVE, LOAD, WRONG = b"save", b"load", b"gnaw"
"""Signatures, as their bytes go over the bus."""
ON_COMMAND = 0x01
PATIENCE = 20
"""Times the time an answer may take: memories are slow."""


def check_can_save(bench: Bench, sub: int) -> Steps[None]:
    yield from _check_can(bench, STORE, sub, "saves")


def check_can_restore(bench: Bench, sub: int) -> Steps[None]:
    yield from _check_can(bench, RESTORE, sub, "restores")


def save(bench: Bench, sub: int) -> Steps[None]:
    bench.is_stored = True
    yield from bench.sdo.write(STORE, sub, SAVE, bench.options.timeout_ms * PATIENCE)


def restore(bench: Bench, sub: int) -> Steps[None]:
    bench.is_stored = True
    yield from bench.sdo.write(RESTORE, sub, LOAD, bench.options.timeout_ms * PATIENCE)


def _check_can(bench: Bench, index: int, sub: int, verb: str) -> Steps[None]:
    """Not applicable if it doesn't, by its EDS or by bit 0 of the object."""
    bench.entry(index, sub)
    if not bench.options.may_store:
        bench.skip("the node's non-volatile memory is not to be written (--no-store)")
    capability = yield from bench.read(index, sub)
    if not capability & ON_COMMAND:
        bench.skip(f"{index:04X}h:{sub:02X}h is {capability:08X}h: the node {verb} nothing on command")
