"""The test bench of a case: the bus, the node's SDO server, the EDS, and a list of changes to undo.

A case reads a parameter before it changes it.  After the case, the changes are undone in reverse order, which is also
the order that PDO and SYNC parameters require.
"""

from collections.abc import Callable
from math import ceil
from typing import NoReturn

from fieldrig.clock import MS
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance.allowed import ALLOWED
from fieldrig_devices.conformance.description import Description, Entry
from fieldrig_devices.conformance.line import Line, Matcher, Seen, Steps, Wait
from fieldrig_devices.conformance.options import Options
from fieldrig_devices.conformance.sdo import MARGIN, Patience, Sdo
from fieldrig_devices.conformance.verdict import Aborted, Failed, NotApplicable, SdoFault

SDO_REQUEST, SDO_RESPONSE, ERROR_CONTROL = 0x600, 0x580, 0x700
DEVICE_TYPE = 0x1000
SHORTEST_PERIOD_MS = 100
"""Least period for heartbeats, SYNC and event timers."""
SETTLE_MS = 50
"""Least time for the node to act on unacknowledged messages, such as NMT commands."""


class Bench:
    def __init__(self, line: Line, eds: Description, options: Options) -> None:
        self.line, self.eds, self.options = line, eds, options
        self.node_id = eds.node_id
        self.sdo = Sdo(
            self.send,
            self.expect,
            line.clock.now_ns,
            (SDO_REQUEST + self.node_id, SDO_RESPONSE + self.node_id),
            Patience(options.timeout_ms, options.first_timeout_ms, options.boot_ms),
        )
        self.undo: list[tuple[int, int, bytes]] = []
        self.has_boot_up = True
        """False after a reset without a boot-up message."""
        self.starts_itself: dict[int, bool] = {}
        """True, by the value of 1F80h, if the node was 'operational' after its boot-up without a command."""
        self.begin()

    def begin(self, case_name: str = "") -> None:
        """Start a new case."""
        self.period_ms = max(
            SHORTEST_PERIOD_MS, self.options.timeout_ms // 5, min(ceil(self.sdo.slowest_ms), self.options.boot_ms)
        )
        """Period for heartbeats, SYNC and event timers that the node and its bus can keep; constant within a case."""
        self._allowed = ALLOWED.get(case_name)
        self.warnings: list[str] = []
        """Doubtful behaviour that breaks no rule; it turns the verdict 'passed' into 'warning'."""
        self.remarks: list[str] = []
        """Remarks for the reader of the report, without effect on the verdict."""
        self.line.seen.clear()
        self.undo.clear()
        self.is_moved = False
        """True if the case has sent NMT commands."""
        self.is_stored = False
        """True if the case has written to non-volatile memory."""
        self.is_upset = False
        """True if the case has caused communication errors, which a reset of communication clears."""

    # Times.

    @property
    def patience_ms(self) -> float:
        """Time-out for an expected frame; it adapts to the node, as the time-out of SDO does."""
        return max(self.options.timeout_ms, self.sdo.within_ms)

    @property
    def settle_ms(self) -> float:
        """Time after one of our frames during which the node may still act as before."""
        return max(SETTLE_MS, min(MARGIN * self.sdo.slowest_ms, self.options.boot_ms))

    def settle(self) -> Steps[None]:
        """Wait until earlier frames of the node have arrived and the node has acted on ours."""
        yield from self.wait(self.settle_ms)

    def barrier(self) -> Steps[None]:
        """Wait for any SDO answer, after which all earlier frames of the node have arrived, too."""
        try:
            yield from self.sdo.read(DEVICE_TYPE)
        except SdoFault:
            yield from self.settle()

    # The bus.

    @property
    def boot_up_id(self) -> int:
        return ERROR_CONTROL + self.node_id

    def send(self, identifier: int, data: bytes = b"") -> None:
        self.line.send(CanFrame(identifier, data))

    def ask(self, identifier: int, length: int = 0) -> None:
        """Send a remote frame."""
        self.line.send(CanFrame(identifier, is_remote=True, remote_length=length))

    def expect(self, wanted: int | Matcher, within_ms: float | None = None) -> Steps[CanFrame | None]:
        """Return the next data frame with this identifier, or that matches; None if there is none in time."""
        until_ns = self._in(self.patience_ms if within_ms is None else within_ms)
        return (yield Wait(_with_identifier(wanted) if isinstance(wanted, int) else wanted, until_ns))

    def wait(self, ms: float) -> Steps[list[Seen]]:
        """Wait, and return the frames that others sent meanwhile."""
        first = len(self.line.seen)
        yield Wait(None, self._in(ms))
        return [seen for seen in self.line.seen[first:] if not seen.is_ours]

    def came(self, identifier: int, first: int) -> list[Seen]:
        """Return data frames with this identifier that others have sent since entry `first` of `seen`."""
        return [
            seen
            for seen in self.line.seen[first:]
            if not seen.is_ours and seen.frame.identifier == identifier and not seen.frame.is_remote
        ]

    def gather(self, identifier: int, first: int, count: int, gap_ms: float = 0) -> Steps[list[Seen]]:
        """Return the frames of `came` once there are `count`, or once the next one is overdue by `patience_ms`.

        `gap_ms` is the time from one frame to the next.
        """
        while len(self.came(identifier, first)) < count:
            frame = yield from self.expect(identifier, gap_ms + self.patience_ms)
            if frame is None:
                break
        return self.came(identifier, first)

    def silence(self, identifier: int, why: str, ms: float) -> Steps[None]:
        """Fail if a frame with this identifier arrives; `why` says why it shouldn't."""
        frame = yield from self.expect(identifier, max(ms, self.settle_ms))
        if frame is not None:
            self.fail(f"no frame {identifier:03X}h ({why})", show(frame))

    # The object dictionary.

    def read(self, index: int, sub: int = 0) -> Steps[int]:
        """Read an unsigned parameter."""
        data = yield from self.sdo.read(index, sub)
        return int.from_bytes(data, "little")

    def change(self, index: int, sub: int, value: int | bytes) -> Steps[None]:
        """Write a parameter, and note its previous value for undoing the change.

        The case is not applicable if the EDS does not allow the value.
        """
        before = yield from self.sdo.read(index, sub)
        data = value if isinstance(value, bytes) else self._encode(index, sub, value, len(before))
        self.check_allowed(index, sub, data)
        if data != before:
            yield from self.sdo.write(index, sub, data)
            self.undo.append((index, sub, before))

    def attempt(self, index: int, sub: int, data: bytes) -> Steps[None]:
        """Write a value that the node should refuse; if it is accepted, it is undone after the case."""
        try:
            before: bytes | None = yield from self.sdo.read(index, sub)
        except Aborted:
            before = None
        yield from self.sdo.write(index, sub, data)
        if before is not None:
            self.undo.append((index, sub, before))

    def refuses(self, steps: Steps[object], *codes: int, what: str) -> Steps[None]:
        """Fail unless `steps` end in an abort with one of the codes; those of CiA's tool for this case go first."""
        codes = self.accepted(*codes)
        expected = f"{what} to be refused with {' or '.join(f'{code:08X}h' for code in codes)}"
        try:
            yield from steps
        except Aborted as abort:
            if abort.code not in codes:
                self.fail(expected, str(abort))
        else:
            self.fail(expected, "no abort: it was accepted")

    def accepted(self, *codes: int) -> tuple[int, ...]:
        """Return the abort codes that this case accepts: those of CiA's log, or else `codes`."""
        return codes if self._allowed is None else self._allowed

    def _encode(self, index: int, sub: int, value: int, size: int) -> bytes:
        """Encode a value in the size that the EDS gives, or else in `size`, as it was read."""
        entry = self.eds.get(index, sub)
        if entry is not None and entry.size is not None:
            size = entry.size
        if value >= 1 << 8 * size:
            self.fail(f"room for {value} in {index:04X}h:{sub:02X}h", f"{size} bytes")
        return value.to_bytes(size, "little")

    # The EDS.

    def check_allowed(self, index: int, sub: int, data: bytes) -> None:
        """Make the case not applicable if a value is outside the limits of the EDS."""
        entry = self.eds.get(index, sub)
        if entry is not None and not entry.allows(data):
            low, high = (f"{limit:X}h" if limit is not None else "any" for limit in (entry.low, entry.high))
            self.skip(f"the EDS limits {entry.key} to {low} to {high}, and the case needs {data[::-1].hex().upper()}h")

    def entry(self, index: int, sub: int = 0, writable: bool = False) -> Entry:
        """Return an entry of the EDS; the case is not applicable without it, or if it should be writable and isn't."""
        entry = self.eds.get(index, sub)
        if entry is None:
            self.skip(f"the EDS has no {index:04X}h sub-index {sub:02X}h")
        if writable and not entry.is_writable:
            self.skip(f"{entry.key} is {entry.access} in the EDS")
        return entry

    def entries(self, is_wanted: Callable[[Entry], bool], what: str) -> list[Entry]:
        """Return the entries of the EDS that are wanted; the case is not applicable if there are none."""
        entries = [entry for entry in self.eds if is_wanted(entry)]
        if not entries:
            self.skip(f"the EDS has no {what}")
        return entries

    # Verdicts.

    def check(self, is_right: bool, expected: str, came: Callable[[], str] | str) -> None:
        if not is_right:
            self.fail(expected, came if isinstance(came, str) else came())

    def fail(self, expected: str, came: str) -> NoReturn:
        raise Failed(expected, came)

    def warn(self, doubt: str) -> None:
        """Note a doubt: the case continues, and its best verdict is 'warning'."""
        self.warnings.append(doubt)

    def skip(self, reason: str) -> NoReturn:
        raise NotApplicable(reason)

    def _in(self, ms: float) -> int:
        return self.line.clock.now_ns() + round(ms * MS)


def _with_identifier(identifier: int) -> Matcher:
    return lambda frame: frame.identifier == identifier and not frame.is_remote and not frame.is_extended


def show(frame: CanFrame) -> str:
    """Return a frame as text, such as `585#43 00 10 00 91 01 0F 00` or `185#remote`."""
    identifier = f"{frame.identifier:08X}" if frame.is_extended else f"{frame.identifier:03X}"
    return f"{identifier}#{'remote' if frame.is_remote else frame.data.hex(' ').upper()}"
