"""`sm.encoder`: the SinCos encoder of an SM motor, on the serial line to its drive.

Source: manual 520, 529, 538 (electronic name plate), 6448-6450, 6933; other modules of this
package contain protocol and memory.  The position of the shaft comes from a wire, as a motion or step by step; without
a wire it keeps the value that was set.  Data written to the memory are stored before the answer.  A plate file that has
changed means another motor, whose memory starts as delivered.
"""

import binascii
import logging
from collections.abc import Iterator, Mapping
from math import tau
from pathlib import Path
from typing import Any, ClassVar, Final, Literal

from pydantic import Field

from fieldrig.bus import Bus
from fieldrig.clock import Clock
from fieldrig.device import RUN, Device, Point, Tool, Value
from fieldrig.front import Front, Group, Knob, Number, Plate
from fieldrig.link import Link
from fieldrig.points.checks import number_in
from fieldrig.settings import Claim, ConfigFile, Settings
from fieldrig.storage.store import Store, restore
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_bus.serial.pty import SerialPty
from fieldrig_bus.serial.rfc2217 import SerialRfc2217
from fieldrig_bus.serial.tcp import SerialTcp
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.hiperface.encoder import HiperfaceEncoder, eeprom_with
from fieldrig_devices.hiperface.faults import MODELS, EncoderFaults
from fieldrig_devices.hiperface.line import StationPort
from fieldrig_devices.hiperface.memory import Eeprom
from fieldrig_devices.hiperface.names import HiperfaceReader
from fieldrig_devices.hiperface.plate import NamePlate, PlateError
from fieldrig_devices.hiperface.plate_file import load_plate
from fieldrig_devices.hiperface.shaft import INCREMENTS, TYPES, Signals, Turning, increments_of, signals
from fieldrig_devices.hiperface.telegram import ADDRESSES, FACTORY_ADDRESS, Status
from fieldrig_devices.line_names.described import LineReader
from fieldrig_devices.motion.front import shaft

log = logging.getLogger(__name__)

PER_TURN: Final[Mapping[str, float]] = {"rad": tau, "turn": 1.0, "count": float(INCREMENTS)}
"""Units per turn on the shaft's wire."""


class SmEncoderSettings(Settings):
    name_plate: ConfigFile = Field(description="plate file of the motor, YAML")
    type: Literal["single_turn", "multi_turn"] | None = Field(
        default=None, description="SRS or SRM; default: according to the plate"
    )
    address: int = Field(
        default=FACTORY_ADDRESS,
        ge=ADDRESSES.start,
        lt=ADDRESSES.stop,
        description="address as delivered; command 55h may change it",
    )
    serial_number: str = Field(
        default="FR0000001", min_length=1, max_length=9, description="serial number of the encoder"
    )
    initial_turns: float = Field(
        default=0.0, ge=0, lt=4096, description="position of the shaft until its wire is driven"
    )
    shaft_wire: str | None = Field(default=None, description="input in rad, turn or count; default: NAME.shaft")
    temperature_wire: str | None = Field(default=None, description="input in degC; default: NAME.temperature")

    def line_reader(self, link: str, device: str) -> LineReader | None:
        """Return a reader of the telegrams at the link `line`."""
        return HiperfaceReader(device) if link == "line" else None

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("line", "HIPERFACE address", self.address, ("address",))


class SmEncoder(Device):
    about = "the SinCos encoder of an SM motor with its name plate (HIPERFACE)"
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        name: str,
        settings: SmEncoderSettings,
        store: Store,
        random: Any,
        line: Link[SerialMessage],
        wires: Link[Signal] | None = None,
    ) -> None:
        self._clock, self._store, self._line = clock, store, line
        self._shaft: Signal = Motion("", settings.initial_turns, "turn")
        self._plate = load_plate(settings.name_plate)
        self._mark = _mark_of(self._plate, settings)
        eeprom, is_damaged = self._kept(settings)
        encoder_type = TYPES[settings.type or ("multi_turn" if self._plate.is_multi_turn else "single_turn")]
        self.encoder = HiperfaceEncoder(
            encoder_type, eeprom, self._turning, serial_number=settings.serial_number, on_change=self._keep
        )
        self.encoder.requests.on_reset = self._on_reset
        if is_damaged:
            self.encoder.requests.report(Status.PARTITION)
        self._faults = EncoderFaults(clock, self.encoder, self._plate, random)
        self.injected = self._faults.injected
        self._station_port = StationPort(clock, line, self.encoder)
        if wires is not None:
            handlers = {
                settings.wire_for(name, "shaft"): self._on_shaft,
                settings.wire_for(name, "temperature"): self._on_temperature,
            }
            wires.on_receive(lambda signal: handlers[signal.name](signal), tuple(handlers))

    def start(self) -> None:
        self._on_reset(self._clock.now_ns())

    def _on_reset(self, now_ns: int) -> None:
        self.encoder.start(now_ns)
        self._line.send(self.encoder.form)

    # ---- memory

    def _kept(self, settings: SmEncoderSettings) -> tuple[Eeprom, bool]:
        """Return the stored memory of this motor, and True if it was damaged."""
        restored = restore(self._store, self._decode)
        if isinstance(restored.content, Eeprom):
            return restored.content, False
        if restored.is_damaged and restored.content is None:
            return Eeprom(settings.address), True
        eeprom = eeprom_with(self._plate)
        eeprom.address = settings.address
        return eeprom, False

    def _decode(self, kept: bytes) -> Eeprom | Literal["other"]:
        """Return the memory of this motor, or a new one for another motor.  Raises ValueError for damaged data."""
        return Eeprom.decode(kept[len(self._mark) :]) if kept[: len(self._mark)] == self._mark else "other"

    def _keep(self) -> None:
        self._store.save(self._mark + self.encoder.eeprom.encode())

    # ---- shaft

    def _turning(self, now_ns: int) -> Turning:
        shaft, per_turn = self._shaft, PER_TURN[self._shaft.unit]
        return Turning(shaft.at(now_ns) / per_turn, shaft.speed_at(now_ns) / per_turn)

    def _signals(self) -> Signals:
        return signals(self._turning(self._clock.now_ns()).turns)

    def _on_shaft(self, signal: Signal) -> None:
        if signal.unit in PER_TURN:
            self._shaft = signal
        else:
            log.debug("%s has the unit %r; expected rad, turn or count", signal.name, signal.unit)

    def _on_temperature(self, signal: Signal) -> None:
        if signal.unit in ("", "degC"):
            self.encoder.requests.set_temperature(signal.value)

    def _put(self, value: Value) -> None:
        self._shaft = Motion("", number_in(value, 0, unit="turns", below=4096), "turn")

    def _heat(self, value: Value) -> None:
        self.encoder.requests.set_temperature(number_in(value, -50, 300, "degC"))

    def front(self) -> Front:
        return Front(
            Plate("", "encoder of an SM motor", {"name plate": "plate"}),
            [
                Group(
                    [
                        shaft("turns", 1.0, "the shaft of the motor"),
                        Knob("turns", "turns", "of the shaft", decimals=4),
                        Number("position", "position", "as in the answer to 42h"),
                        Number("sine", "sine", decimals=3),
                        Number("cosine", "cosine", decimals=3),
                        Knob("temperature", "temperature", "as in the answer to 44h", decimals=1),
                        Number("answers", "answers", "telegrams sent"),
                    ],
                )
            ],
        )

    def points(self) -> Mapping[str, Point]:
        encoder, now_ns = self.encoder, self._clock.now_ns
        return {
            "turns": Point(lambda: self._turning(now_ns()).turns, self._put, "turn", "of the shaft"),
            "position": Point(lambda: encoder.requests.position(now_ns()), None, "step", "as in the answer to 42h"),
            "increments": Point(
                lambda: increments_of(encoder.requests.position(now_ns())), None, "count", "1 000 000 per turn"
            ),
            "sine": Point(lambda: self._signals().sine, None, "", "1024 periods per turn"),
            "cosine": Point(lambda: self._signals().cosine, None, "", "90 degrees ahead"),
            "zero": Point(lambda: self._signals().zero, None, "", "once per turn"),
            "temperature": Point(
                lambda: encoder.requests.temperature_degc, self._heat, "degC", "as in the answer to 44h"
            ),
            "plate": Point(self._plate_in_words, None, "", "motor and serial number, or the mistake in the plate"),
            "address": Point(lambda: encoder.eeprom.address, None, "", ""),
            "answers": Point(lambda: encoder.answered, None, "", "number of telegrams sent"),
        }

    def _plate_in_words(self) -> str:
        fields = self.encoder.eeprom.fields
        try:
            plate = NamePlate.decode(self._faults.plate_in_place(bytes(fields[0].data)) if fields else b"")
        except PlateError as wrong:
            return str(wrong)
        return f"{plate.type}, {plate.serial_number}"

    @classmethod
    def tools(cls, name: str, settings: SmEncoderSettings, links: Mapping[str, Bus[Any]]) -> list[Tool]:
        match links.get("line"):
            case SerialPty() as pty:
                port = str(Path(RUN) / pty.path)
            case SerialTcp(settings=line) if line.listen is not None:
                port = f"socket://{line.listen}"
            case SerialRfc2217(settings=line):
                port = f"rfc2217://{line.listen}"
            case _:
                return []
        return [Tool("name plate", f"fieldrig nameplate read --port {port} --address {settings.address:02X}")]


def _mark_of(plate: NamePlate, settings: SmEncoderSettings) -> bytes:
    """Return the identity of a motor and its encoder in the store."""
    return binascii.crc32(plate.encode() + settings.serial_number.encode() + bytes((settings.address,))).to_bytes(
        4, "big"
    )
