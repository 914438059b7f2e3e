"""Directly represented variables: %IX5.0, %QB3, %MD48, and where they are in their area.

Addresses are indexed by the unit of access: %MD48 is bytes 192 to 195, %MX5.0 the first bit of word 5, and %QX75 bit 75
(PacDrive manual 2970 to 3006, PD-364; contradiction X7 of the digest is decided by 3004, as in CoDeSys V2).

The standard's addresses of several levels (IEC 61131-3:2013, table 16) leave their meaning to the controller.  Here the
leading levels of %QW2.5.7.1 choose a window of its area, and the last one counts in it: %QW2.5.7.2 is the next word.
Windows are laid from the end of the area down, so that the addresses with one number keep their places.
"""

from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.project import WINDOW
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import Located
from fieldrig_devices.iec.types import ArrayType, EnumType, StringType, StructType, SubrangeType, Type

SIZES: Final = {"B": 1, "W": 2, "D": 4, "L": 8}
BITS: Final = {"B": Elementary.BYTE, "W": Elementary.WORD, "D": Elementary.DWORD, "L": Elementary.LWORD}
WORD_BITS: Final = 16


def located(node: tree.Direct, context: Context) -> Located | None:
    """Return the place of an address with the bit string of its size as its type; None after a message."""
    size = SIZES.get(node.size)
    if not node.numbers:
        context.say(node, f"the address {_text(node)} is incomplete", "a number behind it")
        return None
    if len(node.numbers) > (2 if size is None else 1) and context.project.dialect.has_address_levels:
        return _of_levels(node, context)
    if size is None:
        byte, bit = bit_place(node.numbers)
        kind = Elementary.BOOL
    else:
        byte, bit = node.numbers[0] * size, -1
        kind = BITS[node.size]
    if len(node.numbers) > (2 if size is None else 1) or bit >= 8:
        context.say(
            node,
            f"the address {_text(node)} does not exist in the control configuration",
            "%MX with a word and a bit of 0 to 15, or one number",
        )
        return None
    if byte + (size or 1) > context.project.limits.area:
        area = context.project.limits.area
        context.say(node, f"{_text(node)} is byte {byte} of its area", f"a byte below {area} (PD-314)")
        return None
    return _at(Located(node.area, byte, bit, kind), node, context)


def _at(location: Located, node: tree.Direct, context: Context) -> Located | None:
    """Return an address with one number, unless a window is there."""
    addresses = context.project.addresses
    end = location.byte + location.type.size
    if end > addresses.windows_from(location.area, context.project.limits.area):
        context.say(node, f"{_text(node)} is where the addresses with several levels are", "a smaller address")
        return None
    addresses.ends[location.area] = max(end, addresses.ends.get(location.area, 0))
    return location


def _of_levels(node: tree.Direct, context: Context) -> Located | None:
    size, number = SIZES.get(node.size), node.numbers[-1]
    byte, bit = (number // 8, number % 8) if size is None else (number * size, -1)
    if byte + (size or 1) > WINDOW:
        most = WINDOW * 8 - 1 if size is None else WINDOW // size - 1
        context.say(node, f"the last number of {_text(node)} is too large", f"0 to {most}")
        return None
    addresses, area = context.project.addresses, context.project.limits.area
    window = addresses.window(node.area, node.numbers[:-1], area)
    if window is None:
        what = f"there is no place for {_text(node)} in its area"
        context.say(node, what, f"at most {area // WINDOW} groups of addresses with several levels")
        return None
    return Located(node.area, window + byte, bit, Elementary.BOOL if size is None else BITS[node.size])


def bit_place(numbers: tuple[int, ...]) -> tuple[int, int]:
    """Return byte and bit of %MX with these one or two numbers; a bit of 8 or more does not exist."""
    if len(numbers) == 1:
        return numbers[0] // 8, numbers[0] % 8
    if numbers[1] >= WORD_BITS:
        return 0, WORD_BITS
    return numbers[0] * 2 + numbers[1] // 8, numbers[1] % 8


def _text(node: tree.Direct) -> str:
    return f"%{node.area}{node.size}{'.'.join(map(str, node.numbers))}"


def location(node: tree.Direct, kind: Type, context: Context) -> Located | None:
    """Return the place behind AT for a variable of this type; None after a message."""
    place = located(node, context)
    if place is None:
        return None
    dialect = context.project.dialect
    base = kind.base if isinstance(kind, SubrangeType | EnumType) else kind
    if isinstance(base, ArrayType | StructType) or (isinstance(base, StringType) and dialect.mixes_address_sizes):
        return _spread(node, place, kind, context)
    if not isinstance(base, Elementary):
        context.say(node, f"a variable of type {kind} cannot have an address", "an elementary type or an array of them")
        return None
    if place.bit < 0 and base is not Elementary.BOOL and base.size != place.type.size and dialect.mixes_address_sizes:
        return _spread(node, place, kind, context)
    if (base is Elementary.BOOL) != (place.bit >= 0) or base.size != place.type.size:
        sizes = {size: letter for letter, size in SIZES.items() if size < 8 or dialect.has_long_types}
        letter = "X" if base is Elementary.BOOL else sizes.get(base.size)
        expected = f"%{node.area}{letter}" if letter else "a type of at most 4 bytes"
        context.say(node, f"the address {_text(node)} does not have the size of {kind}", expected)
        return None
    limit = dialect.bit_address_bytes
    if limit and place.bit >= 0 and place.byte >= limit:
        context.say(
            node, f"the bit {_text(node)} is in byte {place.byte}", f"a bit in the first {limit} bytes (PD-321)"
        )
        return None
    return Located(place.area, place.byte, place.bit, kind)


def _spread(node: tree.Direct, location: Located, kind: Type, context: Context) -> Located | None:
    """A value from a byte on, such as an array or structure of CoDeSys V2.3."""
    end = location.byte + kind.size
    if location.bit >= 0 or end > context.project.limits.area:
        what = "starts at a bit" if location.bit >= 0 else f"ends at byte {end} of its area"
        expected = f"%{node.area}B, %{node.area}W or %{node.area}D within {context.project.limits.area} bytes (PD-314)"
        context.say(node, f"the variable at {_text(node)} {what}", expected)
        return None
    return Located(location.area, location.byte, -1, kind)
