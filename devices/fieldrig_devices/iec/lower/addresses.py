"""Addresses as text: in memory, or in the area %I, %Q or %M."""

from dataclasses import dataclass, replace

from fieldrig_devices.iec.program import (
    Located,
)


@dataclass(frozen=True, slots=True)
class Address:
    """The sum of `terms` and `offset`."""

    terms: tuple[str, ...]
    offset: int
    is_raw: bool = False
    """True if it came from a pointer."""
    is_frame: bool = False
    """True for a part of the stack."""

    def __str__(self) -> str:
        if not self.terms:
            return str(self.offset)
        first = f"{self.terms[0]} + {self.offset}" if self.offset else self.terms[0]
        return " + ".join([first, *self.terms[1:]])

    def plus(self, offset: int, *terms: str) -> "Address":
        return replace(self, terms=(*self.terms, *terms), offset=self.offset + offset)


@dataclass(frozen=True, slots=True)
class AreaAddress:
    area: str
    terms: tuple[str, ...]
    byte: int
    bit: int

    def __str__(self) -> str:
        return str(Address(self.terms, self.byte))

    def plus(self, offset: int, *terms: str) -> "AreaAddress":
        return replace(self, terms=(*self.terms, *terms), byte=self.byte + offset)


def located(place: Located) -> AreaAddress:
    return AreaAddress(place.area, (), place.byte, place.bit)
