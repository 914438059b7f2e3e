"""The type of a register as a list says it: `UINT16`, `16-bit unsigned integer`, `INT32U`, `unsigned long`, `Float 32`.

A name that a language or a tool has stands for its type.  Other words are read one by one: what kind of number it is,
and how many bits it has.  Where they leave the number of bits open, the column of lengths says it.
"""

import re
from collections.abc import Sequence
from typing import Final

from fieldrig_devices.begin.list_columns import without_accents
from fieldrig_devices.registers.type_names import meant

KINDS: Final = (
    ("string[n]", {"string", "str", "text", "ascii", "char", "chars", "utf", "zeichenkette", "cadena", "stringa",
                   "chaine", "texte", "texto", "testo"}),
    ("bcd", {"bcd"}),
    ("f", {"f", "float", "floating", "ieee", "real", "lreal", "single", "double", "gleitkomma", "flottant", "flotante",
           "reel", "reale"}),
    ("u", {"unsigned", "uint", "ui", "u", "word", "dword", "ulong", "ushort", "uchar", "byte", "vorzeichenlos", "ohne",
           "non", "sans", "sin", "senza", "enum", "enumeration", "bitmap", "bitfield", "bitmask", "flags", "hex"}),
    ("s", {"signed", "int", "integer", "sint", "si", "s", "i", "complement", "short", "long", "ganzzahl", "entier",
           "entero", "intero"}),
    ("bool", {"bool", "boolean", "booleen", "booleano", "bit", "bits", "coil", "flag", "binary"}),
)  # fmt: skip
"""The words that say what a type is, the most certain ones first: `ohne Vorzeichen` and `non signé` are unsigned."""
WORDS_OF_NUMBERS: Final = {"word", "int", "integer", "unsigned", "signed"}
"""Words beside which `double` says a length, and no floating-point number."""
BITS: Final = ("8", "16", "32", "64")
NO_BITS: Final = ("1", "2", "4", "754")
"""Numbers of registers or bytes beside a type, and that of a standard."""
ORDER: Final = re.compile(
    r"\(?\b(?:(?:little|big)[ _-]?endian|(?:byte|word)s?[ _-]?(?:swap\w*|order|first)|swapped[ _-](?:byte|word)s?"
    r"|(?:low|high|lower|upper|least significant|most significant)[ _-](?:word|byte)(?:[ _-]first)?)\b\)?"
)
"""Words for the order of bytes and words, which say nothing of the type."""
OPEN: Final = ("signed", "unsigned")
"""Names that leave the number of bits to the column of lengths."""
BITS_BY_WORDS: Final = {"long": 32, "ulong": 32, "dword": 32, "single": 32, "lreal": 64, "short": 16, "byte": 8}
BITS_BY_LENGTH: Final = {1: 16, 2: 32, 4: 64, 16: 16, 32: 32, 64: 64}
"""Bits by the length in a list, which counts registers, or bits where it is that large."""


def type_of(text: str, length: int | None) -> str | None:
    """Return the type that a cell means, `string[n]` for a text; None if its words say none."""
    plain = ORDER.sub(" ", without_accents(text.casefold()))
    known = meant(plain.replace(" ", ""))
    if known is not None and plain.strip() not in OPEN:
        return known
    words = re.findall(r"[^\W\d_]+|\d+", plain)
    kind = _kind(words)
    if kind is None:  # a name of its own beside an order of bytes, such as `sunssf cdab`
        return next((name for word in plain.split() if (name := meant(word)) is not None), None)
    if kind == "string[n]":
        return kind
    bits = _bits(words, kind) or BITS_BY_LENGTH.get(length or 0)
    if kind == "bool":
        return "bool" if bits is None or words[0] not in BITS else f"u{bits}"
    name = f"{kind}{bits or (32 if kind == 'f' else 16)}"
    is_odd = any(word.isdigit() and word not in (*BITS, *NO_BITS) for word in words[:2])
    return None if is_odd else meant(name)  # BCD with 8 digits has 32 bits


def _kind(words: Sequence[str]) -> str | None:
    kinds = [kind for kind, known in KINDS if known & set(words)]
    if "f" in kinds and "double" in words and WORDS_OF_NUMBERS & set(words):
        kinds.remove("f")
    return kinds[0] if kinds else None


def _bits(words: Sequence[str], kind: str) -> int | None:
    """Return the number of bits that the words say."""
    number = next((word for word in words if word in BITS), None)
    if number is not None:
        return int(number)
    if words.count("long") == 2:
        return 64
    if "double" in words:
        return 64 if kind == "f" else 32
    return next((BITS_BY_WORDS[word] for word in words if word in BITS_BY_WORDS), None)
