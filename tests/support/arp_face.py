"""An ARP card seen from CAN: the test makes the changes that a program would make, and frames are text."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from canopen_bench import parse, show

from fieldrig.clock import MS, Clock, VirtualClock
from fieldrig.device import Device
from fieldrig.link import Link
from fieldrig.loop.background import Job
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.arp.can.exchange import ExchangeSettings
from fieldrig_devices.arp.can.face import CanFace
from fieldrig_devices.arp.card_access import CardState, OnLoaded, Progress
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.language.instructions import WRITABLE
from fieldrig_devices.arp.parameters import Parameters, ParameterValues
from fieldrig_devices.arp.runtime.program import ArpProgram

NODE_ID = 10  # the default of @Par[5]
SCHEDULER_PERIOD_NS = 20 * MS


class OutsideCard:
    """A `CardAccess` without a card.  `asked` keeps the commands."""

    def __init__(self) -> None:
        self.number = 7
        self.V, self.F = [0] * 1001, [0] * 321
        self.I, self.O = [0] * 333, [0] * 333
        self.parameters = Parameters()
        self.errors = CardErrors(lambda code: None)
        self.state = CardState.RUN
        self.program: ArpProgram | None = None
        self.program_name, self.program_object = "WINDER", b""
        self.loading: Progress | None = None
        self.positions, self.speeds, self.tracking_errors = {1: 0, 2: 0}, {1: 0, 2: 0}, {1: 0, 2: 0}
        self.adc, self.dac = dict.fromkeys(range(1, 7), 0), {1: 0, 2: 0}
        self.asked: list[str] = []
        self.is_willing = True
        """True if commands are possible in this state and outputs are not held at 0."""

    def position(self, axis: int) -> int:
        return self.positions[axis]

    def speed(self, axis: int) -> int:
        return self.speeds[axis]

    def tracking_error(self, axis: int) -> int:
        return self.tracking_errors[axis]

    def analog_input(self, channel: int) -> int:
        return self.adc[channel]

    def analog_output(self, channel: int) -> int:
        return self.dac[channel]

    def set_variables(self, first: int, values: Sequence[int]) -> bool:
        self.V[first : first + len(values)] = values
        return True

    def set_flag(self, number: int, bit: int) -> bool:
        if number in WRITABLE:
            self.F[number] = bit
        return number in WRITABLE

    def set_output(self, number: int, bit: int) -> bool:
        if self.is_willing:
            self.O[number] = bit
        return self.is_willing

    def set_parameter(self, group: int, number: int, raw: int) -> bool:
        return self.parameters.set_ram(group, number, raw)

    def save_parameter(self, group: int, number: int, raw: int) -> bool:
        self.asked.append(f"save {group}/{number}")
        is_taken = self.parameters.set_ram(group, number, raw)
        if is_taken:
            self.parameters.flash[group][number] = raw
        return is_taken

    def save_parameters(self, values: ParameterValues) -> bool:
        with self.saving(values):
            return True

    @contextmanager
    def saving(self, values: ParameterValues) -> Iterator[None]:
        yield
        for (group, number), raw in values.items():
            self.asked.append(f"save {group}/{number}")
            self.parameters.flash[group][number] = raw

    def run_program(self) -> bool:
        return self._command("run")

    def stop_program(self) -> bool:
        return self._command("stop")

    def reset(self) -> None:
        self._command("reset")

    def load(self, data: bytes, on_loaded: OnLoaded) -> Job:
        raise NotImplementedError("CAN loads no program")

    def _command(self, what: str) -> bool:
        self.asked.append(what)
        return self.is_willing


class FaceBench:
    """A card with node-ID 10 that has booted; another bench on the same `store` is a power cycle."""

    def __init__(self, store: Store | None = None, **exchange: Any) -> None:
        self.clock = VirtualClock()
        self.can, self.card = RecordedLink[CanFrame](), OutsideCard()
        self.store = store or MemoryStore()
        settings = ExchangeSettings.model_validate(exchange)
        self.face = CanFace(self.clock, "card1", self.can, self.card, self.store, settings)

    def start(self) -> list[str]:
        """Power on, and return the frames that the card sends."""
        self.face.start()
        return self.after(0)

    def refresh(self) -> list[str]:
        """Run one pass of the scheduler, and return the frames that the card sends."""
        self.face.refresh()
        return self.after(0)

    def send(self, *frames: str) -> list[str]:
        for frame in frames:
            self.can.deliver(parse(frame))
        return self.after(0)

    def notice(self, notice: Any) -> None:
        """Notify the card of a state of its CAN controller."""
        self.can.deliver(notice)

    def after(self, ms: float) -> list[str]:
        self.clock.advance_to(self.clock.now_ns() + round(ms * MS))
        return [show(frame) for frame in self.can.take()]

    def sdo(self, request: str) -> str:
        """Answer to an SDO request of 8 bytes in hex."""
        (answer,) = (frame[4:] for frame in self.send(f"60A#{request}") if frame.startswith("58A#"))
        return answer


class FaceDevice(Device):
    """The same card in a rig."""

    def __init__(self, clock: Clock, name: str, can: Link[CanFrame], store: Store) -> None:
        self._clock = clock
        self._face = CanFace(clock, name, can, OutsideCard(), store)

    def start(self) -> None:
        self._face.start()
        self._on_pass()

    def _on_pass(self) -> None:
        self._face.refresh()
        self._clock.call_at(self._clock.now_ns() + SCHEDULER_PERIOD_NS, self._on_pass)
