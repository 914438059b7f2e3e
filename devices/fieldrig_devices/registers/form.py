"""The types of values in registers and their bytes: numbers in four orders, truths, and texts.

Source: none, as Modbus has no types.  `word_order` determines which register of a number comes first, `byte_order`
which byte of each register.  The specification has the high byte first (V1.1b3, 4.2); devices that copy their memory
have the low one.  With a number of four bytes ABCD the four orders are ABCD, CDAB (words), BADC (bytes), and DCBA.  A
text has two characters in each register, the first one in the byte that comes first, and is padded with zeros.  A BCD
number has a decimal digit in each four bits.
"""

import struct
import sys
from typing import Final, Literal

WordOrder = Literal["big", "little"]
ByteOrder = Literal["big", "little"]

FORMATS: Final = {
    "u16": "H",
    "s16": "h",
    "u32": "I",
    "s32": "i",
    "f32": "f",
    "u64": "Q",
    "s64": "q",
    "f64": "d",
    "bcd16": "H",
    "bcd32": "I",
}
BCD_DIGITS: Final = {"bcd16": 4, "bcd32": 8}
FLOATS: Final = frozenset({"f32", "f64"})
TYPE_PATTERN: Final = r"^(bool|[usf]32|[usf]64|[us]16|bcd16|bcd32|string\[([1-9][0-9]?|1[0-9][0-9]|2[0-4][0-9]|250)\])$"
LARGEST_F32: Final = 3.4028234663852886e38
_WORDS: Final = {name: struct.calcsize(f">{code}") // 2 for name, code in FORMATS.items()} | {"bool": 1}
_LARGEST: Final = {"f32": LARGEST_F32, "f64": sys.float_info.max}


def words_in(type: str) -> int:
    """Number of registers that a value of this type occupies."""
    return _WORDS[type] if type in _WORDS else (characters_in(type) + 1) // 2


def characters_in(type: str) -> int:
    """Number of characters in a text type `string[n]`."""
    return int(type[7:-1])


class Form:
    """The form of one type in registers, in one order of its words and bytes."""

    __slots__ = (
        "_are_bytes_swapped",
        "_struct",
        "_word_order",
        "high",
        "is_float",
        "is_number",
        "low",
        "type",
        "words",
    )

    def __init__(self, type: str, word_order: WordOrder = "big", byte_order: ByteOrder = "big") -> None:
        self.type, self.words = type, words_in(type)
        self.is_float = type in FLOATS
        self._struct = struct.Struct(f">{FORMATS[type]}") if type in FORMATS else None
        self.is_number = self._struct is not None
        """True for types other than truths and texts."""
        self._word_order, self._are_bytes_swapped = word_order, byte_order == "little"
        self.low: int | float
        """The lowest number of the type; 0 if it is not a number."""
        self.high: int | float
        """The highest number of the type; 0 if it is not a number."""
        self.low, self.high = self._ends()

    def pack(self, number: int | float) -> bytes:
        """The bytes of a number.  struct.error or OverflowError for a number that does not fit."""
        assert self._struct is not None, "the type is a number"
        if self.type in BCD_DIGITS:
            number = _bcd(int(number), BCD_DIGITS[self.type])
        return self._ordered(self._struct.pack(number))

    def unpack(self, data: bytes) -> int | float:
        """The number in the bytes of its registers."""
        assert self._struct is not None, "the type is a number"
        number: int | float = self._struct.unpack(self._ordered(data))[0]
        return _number_in_bcd(int(number)) if self.type in BCD_DIGITS else number

    def pack_text(self, text: bytes) -> bytes:
        """The bytes of a text, cut and padded to the size of its registers."""
        data = text[: characters_in(self.type)].ljust(2 * self.words, b"\x00")
        return _swapped_bytes(data) if self._are_bytes_swapped else data

    def unpack_text(self, data: bytes) -> str:
        """The text up to the first zero byte."""
        data = _swapped_bytes(data) if self._are_bytes_swapped else data
        return data.split(b"\x00")[0].decode("latin-1")

    def pack_truth(self, value: bool) -> bytes:
        """The register of a truth: 1, or 0."""
        data = b"\x00\x01" if value else b"\x00\x00"
        return _swapped_bytes(data) if self._are_bytes_swapped else data

    def _ordered(self, data: bytes) -> bytes:
        """The bytes of a number with the high one first, in the order of its registers; and back, as a swap is both."""
        if self._word_order == "little":
            data = _swapped_words(data)
        return _swapped_bytes(data) if self._are_bytes_swapped else data

    def _ends(self) -> tuple[int | float, int | float]:
        if not self.is_number:
            return 0, 0
        if self.is_float:
            return -_LARGEST[self.type], _LARGEST[self.type]
        if self.type in BCD_DIGITS:
            return 0, 10 ** BCD_DIGITS[self.type] - 1
        bits = 16 * self.words
        return (0, (1 << bits) - 1) if self.type.startswith("u") else (-(1 << bits - 1), (1 << bits - 1) - 1)


def _bcd(number: int, digits: int) -> int:
    """The bits of a number with up to `digits` decimal digits.  OverflowError for any other."""
    if not 0 <= number < 10**digits:
        raise OverflowError(f"{number} has more than {digits} decimal digits, or a sign")
    return int(str(number), 16)


def _number_in_bcd(bits: int) -> int:
    """The number of BCD digits; four bits above 9, which a client may write, count as what they are."""
    return sum((bits >> 4 * place & 0xF) * 10**place for place in range(8))


def _swapped_words(data: bytes) -> bytes:
    """The words in reverse order; the bytes of each word keep theirs."""
    return b"".join(data[at : at + 2] for at in range(len(data) - 2, -1, -2))


def _swapped_bytes(data: bytes) -> bytes:
    """The two bytes of each word in reverse order; the words keep theirs."""
    swapped = bytearray(data)
    swapped[::2], swapped[1::2] = data[1::2], data[::2]
    return bytes(swapped)
