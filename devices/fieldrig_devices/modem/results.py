"""Result codes of a modem, numeric and verbose.

Source: ITU-T V.250, table 1 (0 to 8); codes of rates above 1200 bit/s, and of W1, are those of the usual chip sets.
"""

from typing import Final, NamedTuple

from fieldrig_bus.telephone.modulation import Agreed


class Result(NamedTuple):
    code: int | None
    """None for a result of an extended command, which has words only (ITU-T V.250, 5.7.3)."""
    text: str


OK: Final = Result(0, "OK")
CONNECT: Final = Result(1, "CONNECT")
RING: Final = Result(2, "RING")
NO_CARRIER: Final = Result(3, "NO CARRIER")
ERROR: Final = Result(4, "ERROR")
NO_DIALTONE: Final = Result(6, "NO DIALTONE")
BUSY: Final = Result(7, "BUSY")
NO_ANSWER: Final = Result(8, "NO ANSWER")

CONNECT_CODES: Final[dict[int, int]] = {
    300: 1, 600: 9, 1200: 5, 2400: 10, 4800: 11, 7200: 13, 9600: 12, 12_000: 14, 14_400: 15, 16_800: 59,
    19_200: 16, 21_600: 61, 24_000: 62, 26_400: 63, 28_800: 64, 31_200: 91, 33_600: 84, 38_400: 17, 57_600: 18,
    115_200: 19,
}  # fmt: skip
"""Numeric codes of `CONNECT rate`; other rates have the code of CONNECT."""
CARRIER_CODES: Final[dict[int, int]] = {
    300: 40, 1200: 46, 2400: 47, 4800: 48, 7200: 49, 9600: 50, 12_000: 51, 14_400: 52, 16_800: 53, 19_200: 54,
    21_600: 55, 24_000: 56, 26_400: 57, 28_800: 58, 31_200: 78, 33_600: 79,
}  # fmt: skip
PROTOCOL: Final = {True: Result(77, "PROTOCOL: LAP-M"), False: Result(76, "PROTOCOL: NONE")}


def modulation(agreed: Agreed) -> tuple[Result, ...]:
    """Return the report of +MR (V.250, 6.4.2)."""
    return Result(None, f"+MCR: {agreed.modulation}"), Result(None, f"+MRR: {agreed.bps}")


def correction(agreed: Agreed) -> Result:
    """Return the report of +ER (V.250, 6.5.5)."""
    return Result(None, f"+ER: {'LAPM' if agreed.is_corrected else 'NONE'}")


NO_COMPRESSION: Final = Result(None, "+DR: NONE")
"""The report of +DR (V.250, 6.6.2)."""


def local_rate(baud: int) -> Result:
    """Return the report of +ILRR (V.250, 6.2.13)."""
    return Result(None, f"+ILRR: {baud}")


def connect(bps: int, has_rate: bool) -> Result:
    """Return CONNECT, with the rate from X1 on."""
    return Result(CONNECT_CODES.get(bps, CONNECT.code), f"CONNECT {bps}") if has_rate else CONNECT


def carrier(bps: int) -> Result:
    return Result(CARRIER_CODES.get(bps, 40), f"CARRIER {bps}")


def written(result: Result, is_verbose: bool, end: bytes, feed: bytes) -> bytes:
    """Return the bytes of a result code (V.250, 5.7.1); `end` and `feed` are the characters of S3 and S4."""
    if is_verbose:
        return end + feed + result.text.encode() + end + feed
    return (result.text if result.code is None else str(result.code)).encode() + end


def text_written(text: str, is_verbose: bool, end: bytes, feed: bytes) -> bytes:
    """Return the bytes of an information text."""
    lines = (end + feed).join(line.encode() for line in text.splitlines())
    return (end + feed if is_verbose else b"") + lines + end + feed
