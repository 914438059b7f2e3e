"""SDO 28 to 30: additional SDO servers and clients, and their parameters after a reset.

Source: CiA 301 7.5.2.33 (1200h), 7.5.2.34 (1280h).
"""

from fieldrig_devices.conformance import nmt, store
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.line import Steps

SERVERS, CLIENTS = (0x1201, 0x127F), (0x1280, 0x12FF)
INVALID = 1 << 31
NO_OBJECT = 0x0602_0000
Values = dict[tuple[int, int], bytes]


@case(
    "2.28",
    "SDO 28",
    "Parameters of additional SDO servers can be read and match the EDS; reading others is refused.",
    "CiA 301 7.5.2.33",
)
def read_servers(bench: Bench) -> Steps[None]:
    for index in range(SERVERS[0], SERVERS[1] + 1):
        if index not in bench.eds:
            yield from bench.refuses(bench.sdo.read(index), NO_OBJECT, what=f"reading {index:04X}h:00h")
    values = yield from _read(bench, SERVERS)
    for (index, sub), came in values.items():
        entry = bench.eds.get(index, sub)
        if entry is not None and entry.default is not None:
            bench.check(came == entry.default, f"{entry.default.hex(' ')} in {entry.key}", came.hex(" "))


@case("2.29", "SDO 29", "A reset of communication restores the parameters of additional servers.", "CiA 301 7.3.2.2")
def reset_servers(bench: Bench) -> Steps[None]:
    yield from nmt.restart(bench)
    before = yield from _read_all(bench, SERVERS, "additional SDO server")
    yield from _change_all(bench, before)
    yield from nmt.restart(bench)
    after = yield from _read_all(bench, SERVERS, "additional SDO server")
    _check_same(bench, before, after, "after the reset")


@case("2.30", "SDO 30", "Stored parameters of SDO clients survive a reset.", "CiA 301 7.5.2.13, 7.5.2.34")
def stored_clients(bench: Bench) -> Steps[None]:
    before = yield from _read_all(bench, CLIENTS, "SDO client")
    yield from store.check_can_save(bench, store.ALL)
    yield from _change_all(bench, before)
    changed = yield from _read_all(bench, CLIENTS, "SDO client")
    yield from store.save(bench, store.ALL)
    yield from nmt.restart(bench)
    after = yield from _read_all(bench, CLIENTS, "SDO client")
    _check_same(bench, changed, after, "after saving and the reset")


def _read_all(bench: Bench, indices: tuple[int, int], what: str) -> Steps[Values]:
    if not bench.eds.indices(*indices):
        bench.skip(f"the EDS has no {what} ({indices[0]:04X}h and following)")
    return (yield from _read(bench, indices))


def _read(bench: Bench, indices: tuple[int, int]) -> Steps[Values]:
    found = bench.eds.indices(*indices)
    values: Values = {}
    for entry in bench.eds:
        if entry.index in found and entry.is_readable:
            values[entry.index, entry.sub] = yield from bench.sdo.read(entry.index, entry.sub)
    return values


def _change_all(bench: Bench, values: Values) -> Steps[None]:
    """Change the node-ID in sub-index 3, or a COB-ID that is not in use."""
    is_changed = False
    for (index, sub), value in values.items():
        entry = bench.eds.get(index, sub)
        if entry is None or not entry.is_writable:
            continue
        number = int.from_bytes(value, "little")
        if sub == 3:
            yield from bench.change(index, sub, number % 127 + 1)
            is_changed = True
        elif sub in (1, 2) and number & INVALID:
            yield from bench.change(index, sub, number ^ 0x2 | INVALID)
            is_changed = True
    if not is_changed:
        bench.skip("none of these parameters can be changed")


def _check_same(bench: Bench, right: Values, came: Values, when: str) -> None:
    for (index, sub), value in right.items():
        bench.check(
            came[index, sub] == value, f"{value.hex(' ')} in {index:04X}h:{sub:02X}h {when}", came[index, sub].hex(" ")
        )
