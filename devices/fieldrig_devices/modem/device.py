"""`modem`: a telephone modem with the Hayes command set, between a serial line and a telephone network.

Source: manual rows PD-244 to PD-249 (what a controller asks of it), ITU-T V.250.  Other modules of this package contain
commands, dialling and calls.
Left out: fax, voice, V.90, compression and retrains.
"""

import logging
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Final, Literal

from pydantic import Field

from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.settings import Claim, Settings
from fieldrig.storage.store import Store, StoreError, restore
from fieldrig_bus.serial.message import ModemInputs, SerialMessage, inputs_from
from fieldrig_bus.telephone.message import TelephoneMessage
from fieldrig_bus.telephone.modulation import FASTEST_BPS, SLOWEST_BPS
from fieldrig_devices.modem import results
from fieldrig_devices.modem.engine import Engine, Mode
from fieldrig_devices.modem.faults import MODELS, LineUnplugged, PowerOff, SerialMiswired, SerialUnplugged
from fieldrig_devices.modem.front import FRONT
from fieldrig_devices.modem.plugs import SerialPlug, TelephonePlug
from fieldrig_devices.modem.profile import Memory
from fieldrig_devices.modem.results import Result
from fieldrig_devices.modem.rules import Build

log = logging.getLogger(__name__)

BAUD: Final = 38_400  # PD-245


class ModemSettings(Settings):
    baud: int = Field(
        default=BAUD, ge=300, le=230_400, description="rate of the serial line until the terminal sets another"
    )
    highest_bps: int = Field(
        default=FASTEST_BPS, ge=SLOWEST_BPS, le=FASTEST_BPS, description="highest rate of the modem, in bit/s"
    )
    training_ms: float = Field(default=3000, ge=1, le=30_000, description="duration of the handshake")
    chip_set: Literal["rockwell", "other"] = Field(
        default="rockwell", description="other: the commands of Rockwell's chip sets, such as +MS, are errors"
    )
    paced: bool = Field(
        default=True, description="true: data to the terminal take the time of the serial line; false: no time"
    )

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("line", "end of", "a modem", ("kind",))


class Modem(Device):
    about = "a telephone modem with the Hayes command set"
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        settings: ModemSettings,
        store: Store,
        random: Any,
        line: Link[SerialMessage],
        telephone: Link[TelephoneMessage],
    ) -> None:
        self._store = store
        self._serial = SerialPlug(line, clock)
        self._telephone = TelephonePlug(telephone)
        build = Build(
            settings.baud,
            settings.highest_bps,
            round(settings.training_ms * MS),
            settings.chip_set == "rockwell",
            settings.paced,
        )
        memory = restore(store, Memory.decode).content or Memory()
        self._engine = Engine(clock, build, memory, self._save, self._serial, self._telephone)
        self._serial.on_receive(self._engine.on_serial)
        self._telephone.on_receive(self._engine.on_network)
        self.injected = InjectedFaults(clock, MODELS, Faults(Fault, random), on_change=self._on_faults)
        self._is_started = False

    def start(self) -> None:
        self._is_started = True
        self._serial.send(self._engine.side.end.form)
        self._on_faults()

    def _save(self, memory: Memory) -> Result:
        try:
            self._store.save(memory.encode())
        except StoreError as fault:
            log.debug("the profile is not stored: %s", fault)
            return results.ERROR
        return results.OK

    def _on_faults(self) -> None:
        assert self.injected is not None
        first = self.injected.first
        if not self._is_started:
            return
        self._serial.put(first(SerialUnplugged) is None)
        self._serial.is_miswired = first(SerialMiswired) is not None
        self._telephone.put(first(LineUnplugged) is None)
        is_off, was_off = first(PowerOff) is not None, self._engine.mode is Mode.OFF
        if is_off and not was_off:
            self._engine.power_off()
        elif was_off and not is_off:
            self._engine.power_on()

    def front(self) -> Front:
        return FRONT

    def points(self) -> Mapping[str, Point]:
        engine, plug = self._engine, self._serial
        side, call = engine.side, engine.call

        def own() -> ModemInputs:
            """Return the lines as the terminal sees them."""
            return inputs_from(side.end.lines)

        return {
            "mode": Point(lambda: engine.mode.value, about="off, command, online or online command"),
            "call": Point(lambda: call.state.value, about="idle, seized, dialling, waiting for a carrier or connected"),
            "rate": Point(lambda: call.agreed.bps if call.agreed else 0, unit="bit/s", about="of the call"),
            "modulation": Point(lambda: call.agreed.modulation if call.agreed else "", about="of the call"),
            "corrected": Point(lambda: bool(call.agreed and call.agreed.is_corrected), about="errors are corrected"),
            "rings": Point(lambda: engine.interpreter.profile.registers[1], about="register S1"),
            "dcd": Point(lambda: own().dcd, about="output: a carrier"),
            "dsr": Point(lambda: own().dsr, about="output: ready"),
            "cts": Point(lambda: own().cts, about="output: the terminal may send"),
            "ri": Point(lambda: own().ri, about="output: it rings"),
            "dtr": Point(lambda: side.terminal.dtr, about="input: the terminal is ready"),
            "rts": Point(lambda: side.terminal.rts, about="input: the modem may send"),
            "sd": Point(lambda: plug.is_receiving, about="data come from the terminal"),
            "rd": Point(lambda: plug.is_sending, about="data go to the terminal"),
            "baud": Point(lambda: side.end.form.baud, unit="bit/s", about="of the serial line"),
        }
