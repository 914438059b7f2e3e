"""Storing and restoring parameters.

Source: CiA 301 7.5.2.13 (1010h), 7.5.2.14 (1011h).
"""

from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.line import Steps

STORE, RESTORE = 0x1010, 0x1011
ALL, COMMUNICATION = 1, 2
"""Sub-indices of 1010h and 1011h."""
SAVE, LOAD, WRONG = b"save", b"load", b"gnaw"
"""Signatures as bytes on the bus."""
ON_COMMAND = 0x01
PATIENCE = 20
"""Factor for the time-out of writing to a memory, which is slow."""


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
    """Make the case not applicable if the EDS or bit 0 of the object says that the node doesn't support it."""
    bench.entry(index, sub)
    if not bench.options.may_store:
        bench.skip("--no-store forbids writing the node's non-volatile memory")
    capability = yield from bench.read(index, sub)
    if not capability & ON_COMMAND:
        bench.skip(f"{index:04X}h:{sub:02X}h is {capability:08X}h: the node {verb} nothing on command")
