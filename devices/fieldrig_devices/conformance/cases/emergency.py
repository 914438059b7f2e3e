"""Emergency 01 to 06: EMCY, the error register and the error history.

Source: CiA 301 7.2.7, 7.5.2.2 (1001h), 7.5.2.4 (1003h), 7.5.2.17 (1014h).
"""

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance import errors
from fieldrig_devices.conformance.bench import Bench, show
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.errors import Forced
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.verdict import Aborted

REGISTER, HISTORY, COB_ID = 0x1001, 0x1003, 0x1014
GENERIC, RESERVED = 0x01, 0x40
NO_DATA, GENERAL = 0x0800_0024, 0x0800_0000
EMCY_BASE = 0x80


@case(
    "5.1",
    "Emergency 01",
    "The COB-ID of EMCY is 80h plus the node-ID, or the default of the EDS.",
    "CiA 301 7.5.2.17, 7.3.3",
)
def cob_id(bench: Bench) -> Steps[None]:
    entry = bench.entry(COB_ID)
    default = EMCY_BASE + bench.node_id
    right = default if entry.default is None else int.from_bytes(entry.default, "little")
    came = yield from bench.read(COB_ID)
    bench.check(came == right, f"{right:08X}h in 1014h:00h", f"{came:08X}h")


@case("5.2", "Emergency 02", "The error register is one byte; bit 0 is set with any error.", "CiA 301 7.5.2.2")
def register(bench: Bench) -> Steps[None]:
    data = yield from bench.sdo.read(REGISTER)
    bench.check(len(data) == 1, "one byte in 1001h:00h", data.hex(" "))
    _check_register(bench, data[0])


@case(
    "5.3",
    "Emergency 03",
    "The history has the number of its errors; reading an empty history gives no data.",
    "CiA 301 7.5.2.4",
)
def history(bench: Bench) -> Steps[None]:
    bench.entry(HISTORY, 1)
    count = yield from bench.read(HISTORY)
    if count > 0:
        data = yield from bench.sdo.read(HISTORY, 1)
        bench.check(len(data) == 4, "4 bytes in 1003h:01h", data.hex(" "))
        return
    what = "reading 1003h:01h while 1003h:00h is 0"
    yield from bench.refuses(bench.sdo.read(HISTORY, 1), NO_DATA, GENERAL, what=what)


@case(
    "5.4",
    "Emergency 04",
    "An error is reported by an EMCY message of eight bytes with its code.",
    "CiA 301 7.2.7.1, table 26",
)
def forced(bench: Bench) -> Steps[None]:
    force = yield from errors.force(bench)
    frame = _checked_frame(bench, force)
    code = int.from_bytes(frame.data[:2], "little")
    bench.check(code == force.code, f"error code {force.code:04X}h after {force.how}", f"{code:04X}h")
    _check_register(bench, frame.data[2])


@case("5.5", "Emergency 05", "The error register equals that of the latest EMCY message.", "CiA 301 7.2.7.1, 7.5.2.2")
def register_during_error(bench: Bench) -> Steps[None]:
    """Compare 1001h with the latest EMCY message.

    A transient event, such as an RPDO that is too short, may leave the register at 0: in the log of CiA's tool, EMCY
    8210h has 00h, and so has 1001h.
    """
    force = yield from errors.force(bench)
    _checked_frame(bench, force)
    came = yield from bench.read(REGISTER)
    frame = yield from errors.latest(bench)
    bench.check(came == frame.data[2], f"{frame.data[2]:02X}h in 1001h:00h, as in the latest EMCY", f"{came:02X}h")
    _check_register(bench, came)


@case("5.6", "Emergency 06", "The newest error of the history is that of the latest EMCY message.", "CiA 301 7.5.2.4")
def history_during_error(bench: Bench) -> Steps[None]:
    bench.entry(HISTORY, 1)
    before = yield from bench.read(HISTORY)
    frame = _checked_frame(bench, (yield from errors.force(bench)))
    count = yield from bench.read(HISTORY)
    least = min(before + 1, len(bench.eds.members(HISTORY)))
    bench.check(count >= least, f"at least {least} errors in 1003h:00h", str(count))
    try:
        newest = yield from bench.sdo.read(HISTORY, 1)
    except Aborted as abort:
        bench.fail("the error in 1003h:01h", str(abort))
    right = frame.data[:2].hex(" ")
    bench.check(newest[:2] == frame.data[:2], f"error code {right} in 1003h:01h, as in EMCY", newest.hex(" "))


def _checked_frame(bench: Bench, force: Forced) -> CanFrame:
    if force.frame is None:
        bench.fail(f"an EMCY message after {force.how}", "none")
    bench.check(len(force.frame.data) == 8, "8 bytes of EMCY", show(force.frame))
    return force.frame


def _check_register(bench: Bench, came: int) -> None:
    bench.check(came == 0 or bool(came & GENERIC), "bit 0 (generic error) with any other", f"{came:02X}h")
    bench.check(not came & RESERVED, "bit 6, which is reserved, at 0", f"{came:02X}h")
