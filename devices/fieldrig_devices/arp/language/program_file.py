"""Read the program that a rig file names: a source or an object, compiled when the card is built.

Source: manual 5.2; digest chapter 17.  The two digits at the end of the file's name are the card's number.
"""

from pathlib import Path

from fieldrig.errors import ConfigError
from fieldrig.errors import Mistake as Wrong
from fieldrig.text.source_text import decoded
from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.language.files import ObjectError, decode, encode, system_of
from fieldrig_devices.languages.mistakes import CompileError, Mistake

_OBJECT = b"ARP OBJECT "
_BINARY_OBJECT = b"ARPO"
_FILLING = b"\x1a\0"
"""The characters that DOS puts behind the end of a text."""


def read_program(path: Path, number: int) -> bytes:
    """Return the object file for card `number`.  Raises ConfigError with every mistake, by line and column."""
    data = path.read_bytes()
    named = system_of(path)
    if data.startswith(_BINARY_OBJECT):
        raise ConfigError([Wrong(str(path), None, "", "it is a binary object", "name the object in ASCII, .Dnn")])
    if data.startswith(_OBJECT):
        data = data.rstrip(_FILLING)
        try:
            named = decode(data).system
        except ObjectError as cause:
            raise ConfigError([Wrong(str(path), None, "", str(cause), "compile it again")]) from cause
    if named not in (None, number):
        what = f"it is for card {named:02}, and the number of this one is {number}"
        raise ConfigError([Wrong(str(path), None, "", what, f"set number: {named}, or compile it for {number:02}")])
    if data.startswith(_OBJECT):
        return data
    try:
        text = decoded(data)
    except ValueError as cause:
        raise ConfigError([Wrong(str(path), None, "", str(cause), "a shorter file")]) from cause
    try:
        return encode(compile_text(text), path.stem, number)
    except CompileError as cause:
        wrong = [_shown(path, mistake) for mistake in cause.mistakes if not mistake.is_note]
        raise ConfigError(wrong) from cause


def _shown(path: Path, mistake: Mistake) -> Wrong:
    expected = f"expected {mistake.expected}" if mistake.expected else ""
    return Wrong(str(path), mistake.line, "", mistake.what, expected, mistake.column)
