"""Messages of the telephone network as bytes, for other processes and traces, and as a line of text.

The first byte is the kind of message; numbers after it are little endian.
"""

import struct
from collections.abc import Callable
from typing import Any

from fieldrig.faults import note
from fieldrig.faults.note import FaultNote
from fieldrig_bus.telephone.message import (
    Carrier,
    Dial,
    Heard,
    Hook,
    Offer,
    Ready,
    Ring,
    TelephoneMessage,
    Tone,
    check,
)
from fieldrig_bus.telephone.modulation import RATES, Modulation

DATA, HOOK, DIAL, RING, HEARD, OFFER, CARRIER, READY = range(8)

_OFFER = struct.Struct("<BI")  # error correction, highest rate of the line
_MODULATION = struct.Struct("<BII")  # place in RATES, lowest and highest rate
_CARRIER = struct.Struct("<IBB")
_NAMES = tuple(RATES)
_LONGEST_SHOWN = 24


def encode(message: TelephoneMessage | FaultNote) -> bytes:
    if type(message) is bytes:
        return b"\x00" + message
    if isinstance(message, FaultNote):
        return note.encode(message)
    tag, body = _ENCODERS[type(message)]
    return bytes((tag,)) + body(message)


def decode(data: bytes) -> Any:
    """The inverse of `encode`.  ValueError for anything else."""
    if data[:1] == b"\x00":
        return data[1:]
    if data.startswith(note.LEAD):
        return note.decode(data)
    try:
        message = _DECODERS[data[0]](data[1:])
        check(message)
    except (struct.error, KeyError, IndexError, ValueError) as cause:
        raise ValueError(f"not a message of the telephone network: {data[:80].hex(' ')}") from cause
    return message


def show(message: TelephoneMessage | FaultNote) -> str:
    match message:
        case bytes():
            shown = message[:_LONGEST_SHOWN]
            rest = f" … {len(message)} bytes" if len(message) > _LONGEST_SHOWN else ""
            return f"{shown.hex(' ')}  {repr(shown)[1:]}{rest}"
        case Hook(is_off=is_off):
            return "off hook" if is_off else "on hook"
        case Dial(digits=digits):
            return f"dials {digits}"
        case Ring(is_on=is_on, caller=caller):
            return f"ring {'on' if is_on else 'off'}{f', from {caller}' if caller else ''}"
        case Heard(tone=tone):
            return f"tone: {tone.name.lower()}"
        case Offer(modulations=modulations):
            return "offers " + ", ".join(f"{name} {low}-{high}" for name, low, high in modulations)
        case Carrier(bps=bps, is_corrected=is_corrected):
            return f"carrier {bps} bit/s{', error correction' if is_corrected else ''}" if bps else "no carrier"
        case Ready(is_ready=is_ready):
            return "ready" if is_ready else "not ready"
        case FaultNote():
            return note.show(message)


def _encode_offer(offer: Offer) -> bytes:
    modulations = [_MODULATION.pack(_NAMES.index(name), low, high) for name, low, high in offer.modulations]
    return _OFFER.pack(offer.correction, offer.line_bps) + b"".join(modulations)


def _decode_offer(body: bytes) -> Offer:
    correction, line_bps = _OFFER.unpack_from(body)
    modulations = tuple(
        Modulation(_NAMES[name], low, high) for name, low, high in _MODULATION.iter_unpack(body[_OFFER.size :])
    )
    return Offer(modulations, correction, line_bps)


def _decode_carrier(body: bytes) -> Carrier:
    bps, is_corrected, is_paced = _CARRIER.unpack(body)
    return Carrier(bps, _TRUTHS[is_corrected], _TRUTHS[is_paced])


_TRUTHS = (False, True)

_ENCODERS: dict[type, tuple[int, Callable[[Any], bytes]]] = {
    Hook: (HOOK, lambda message: bytes((message.is_off,))),
    Dial: (DIAL, lambda message: message.digits.encode()),
    Ring: (RING, lambda message: bytes((message.is_on,)) + message.caller.encode()),
    Heard: (HEARD, lambda message: bytes((message.tone,))),
    Offer: (OFFER, _encode_offer),
    Carrier: (CARRIER, lambda message: _CARRIER.pack(message.bps, message.is_corrected, message.is_paced)),
    Ready: (READY, lambda message: bytes((message.is_ready,))),
}
_DECODERS: dict[int, Callable[[bytes], TelephoneMessage]] = {
    HOOK: lambda body: Hook(_TRUTHS[int.from_bytes(body)]),
    DIAL: lambda body: Dial(body.decode("ascii")),
    RING: lambda body: Ring(_TRUTHS[body[0]], body[1:].decode("ascii")),
    HEARD: lambda body: Heard(Tone(int.from_bytes(body))),
    OFFER: _decode_offer,
    CARRIER: _decode_carrier,
    READY: lambda body: Ready(_TRUTHS[int.from_bytes(body)]),
}
