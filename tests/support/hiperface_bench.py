"""An encoder, a motor's plate, and telegrams put together by hand: they share nothing with the code."""

from fieldrig.clock import MS, VirtualClock
from fieldrig_devices.hiperface.encoder import HiperfaceEncoder, eeprom_with
from fieldrig_devices.hiperface.plate import NamePlate
from fieldrig_devices.hiperface.shaft import TYPES, Turning, TypeName

PLATE = NamePlate(
    type="SM-100/30/080",
    serial_number="17-0001",
    rated_speed_rpm=3000,
    max_speed_rpm=5000,
    rated_torque_nm=6.3,
    standstill_torque_nm=8.0,
    peak_torque_nm=32.0,
    rated_current_a=3.94,
    standstill_current_a=5.0,
    peak_current_a=20.0,
    torque_constant_nm_per_a=1.6,
    inertia_kgcm2=4.2,
    pole_pairs=4,
    is_multi_turn=True,
    offset_increments=-2,
    brake_torque_nm=9.0,
)

PLATE_BYTES = bytes.fromhex(
    "46524e50 01 64"
    "534d2d3130302f33302f303830 0000000000000000000000"  # SM-100/30/080
    "31372d30303031 000000000000000000"  # 17-0001
    "0bb8 1388"  # 3000, 5000 1/min
    "0000189c 00001f40 00007d00"  # 6.3, 8, 32 Nm
    "018a 01f4 07d0"  # 3.94, 5, 20 A
    "0640"  # 1.6 Nm/A
    "00001068"  # 4.2 kgcm2
    "04 01"  # pole pairs, multi-turn
    "000f4240 fffffffe"  # 1 000 000, -2
    "04b0 0578"  # 120, 140 degrees Celsius
    "0708"  # 1800 s
    "00002328"  # 9 Nm
    "0028 0014"  # 40, 20 ms
)
"""The plate by hand, without its CRC."""


def crc16(data: bytes) -> bytes:
    """CRC-16/CCITT-FALSE bit by bit."""
    register = 0xFFFF
    for octet in data:
        register ^= octet << 8
        for _ in range(8):
            register = (register << 1 ^ (0x1021 if register & 0x8000 else 0)) & 0xFFFF
    return register.to_bytes(2, "big")


def telegram(text: str, address: int = 0x40) -> bytes:
    """`text` is command and data in hex."""
    body = bytes((address,)) + bytes.fromhex(text)
    total = 0
    for octet in body:
        total ^= octet
    return body + bytes((total,))


class EncoderBench:
    """An encoder by itself, its shaft, and a clock; it has been on for a second."""

    def __init__(self, kind: TypeName = "multi_turn", turns: float = 0.0, plate: NamePlate | None = PLATE) -> None:
        self.clock = VirtualClock(1000 * MS)
        self.turning = Turning(turns)
        self.kept: list[bytes] = []
        eeprom = eeprom_with(plate or PLATE)
        if plate is None:
            eeprom.fields.clear()
        self.encoder = HiperfaceEncoder(
            TYPES[kind],
            eeprom,
            lambda _now_ns: self.turning,
            on_change=lambda: self.kept.append(eeprom.encode()),
        )

    def send(self, data: bytes) -> None:
        """Send bytes that arrive all at this instant."""
        self.encoder.receive(self.clock.now_ns(), data)

    def heard(self, within_ms: float = 300.0) -> bytes:
        """The next answer; b"" if none comes."""
        until_ns = self.clock.now_ns() + round(within_ms * MS)
        while (next_ns := self.encoder.next_ns()) is not None and next_ns <= until_ns:
            self.clock.advance_to(next_ns)
            if sent := self.encoder.due(next_ns):
                return sent
        self.clock.advance_to(until_ns)
        return b""

    def ask(self, text: str) -> str:
        """Command and data in hex; the same of the answer, whose address and checksum must be right."""
        self.wait(10)
        self.send(telegram(text))
        answer = self.heard()
        if not answer:
            return ""
        assert answer == telegram(answer[1:-1].hex(), self.encoder.eeprom.address), answer.hex(" ")
        return answer[1:-1].hex(" ")

    def wait(self, milliseconds: float) -> None:
        self.clock.advance_to(self.clock.now_ns() + round(milliseconds * MS))
