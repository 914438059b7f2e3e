"""Faults on a CAN bus whose medium is outside the rig: they act at a device's own end of the bus.

`drop`, `delay`, `duplicate` and `replace` affect what the device sends, if their `node` is this device or left out.
A `drop` that names this device among its `receivers` affects what it hears, regardless of the sender.  Bits, error
frames and other controllers are out of reach: kinds with a model have these faults.
"""

from collections.abc import Callable, Sequence
from random import Random
from typing import Annotated, Any, Final

from pydantic import Field

from fieldrig.bus import Attachment
from fieldrig.faults.faults import models_of
from fieldrig.faults.injected import InjectedFaults
from fieldrig.link import Link
from fieldrig_bus.can.faults import Delay, Drop, Duplicate, Fault, Faults, Replace
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import FaultNote, Notice

LinkFault = Annotated[Drop | Delay | Duplicate | Replace, Field(discriminator="what")]
MODELS: Final = models_of(LinkFault)


class FaultyLink:
    """A link that drops, delays, duplicates and changes frames on their way to the link that it wraps."""

    def __init__(self, at: Attachment, link: Link[Any], faults: Sequence[LinkFault], random: Random) -> None:
        self._at = at
        self.inner = link
        """The link to which the frames go."""
        self._faults = Faults(random)
        self.injected = InjectedFaults(at.clock, MODELS, self._faults)
        """The faults of this end."""
        for fault in faults:
            self.injected.add(fault)
        self._count = 0
        self._held_until_ns = 0

    def send(self, message: CanFrame | Notice) -> None:
        if not isinstance(message, CanFrame):
            self.inner.send(message)
            return
        member, now_ns = self._at.member, self._at.clock.now_ns()
        self._count += 1
        key, frames = self._count << 1, [message]
        for fault in self._faults.of(Drop, Delay, Duplicate, Replace):
            settings = fault.settings
            if (isinstance(settings, Drop) and settings.receivers is not None) or not fault.applies(
                now_ns, member, message, key
            ):
                continue
            fault.applied += 1
            match settings:
                case Drop():
                    frames = []
                    self._note(fault, "dropped")
                case Delay():
                    self._held_until_ns = max(self._held_until_ns, now_ns + settings.delay_ns)
                    self._note(fault, "delayed")
                case Duplicate():
                    frames = frames * 2
                    self._note(fault, "duplicated")
                case Replace():
                    frames = [settings.of(frame) for frame in frames]
                    self._note(fault, f"data replaced, was {message.data.hex(' ')}")
        for frame in frames:
            self._send(now_ns, frame)

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        def hear(message: Any) -> None:
            if not isinstance(message, CanFrame) or not self._is_lost(message):
                handler(message)

        self.inner.on_receive(hear, interest)

    def _send(self, now_ns: int, frame: CanFrame) -> None:
        if now_ns >= self._held_until_ns:
            self.inner.send(frame)
        else:  # in order: the clock calls actions of the same instant in the order of asking
            self._at.clock.call_at(self._held_until_ns, lambda: self.inner.send(frame))

    def _is_lost(self, frame: CanFrame) -> bool:
        self._count += 1
        member, now_ns = self._at.member, self._at.clock.now_ns()
        for fault in self._faults.of(Drop):
            settings = fault.settings
            if not isinstance(settings, Drop) or settings.receivers is None or settings.node is not None:
                continue  # the sender of a frame is not known here
            if member in settings.receivers and fault.applies(now_ns, "", frame, self._count << 1 | 1):
                fault.applied += 1
                self._note(fault, f"dropped for {member}")
                return True
        return False

    def _note(self, fault: Fault, what: str) -> None:
        self._at.heard(self._at.member, FaultNote(fault.number, what))
