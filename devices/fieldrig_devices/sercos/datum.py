"""The operation datum behind an IDN, with its seven elements, and the table of all data of a drive.

Source: IEC 61491 by its public facts.  Numbers are sent low byte first; texts and lists begin with their actual and
largest length in bytes.
"""

from collections.abc import Callable, Container, Iterable, Iterator

from fieldrig_devices.sercos.idn import READ_ONLY, Attribute, Code, Element, Format, ServiceError, idn_text


class Datum:
    """An operation datum.  Numbers are stored as bytes, as they are sent over the ring."""

    __slots__ = (
        "attribute", "data", "idn", "largest", "maximum", "minimum", "name", "reader", "status", "unit", "watchers",
        "writer",
    )  # fmt: skip

    def __init__(
        self,
        idn: int,
        name: str,
        attribute: Attribute,
        value: int | str | Iterable[int] = 0,
        *,
        unit: str = "",
        minimum: int | None = None,
        maximum: int | None = None,
        largest: int = 256,
    ) -> None:
        """`largest` is the largest length of a list or text, in bytes."""
        self.idn, self.name, self.attribute, self.unit = idn, name, attribute, unit
        self.minimum, self.maximum, self.largest = minimum, maximum, largest
        self.status = 0
        """The first element: the status of a procedure command."""
        self.reader: Callable[[], bytes] | None = None
        """Supplies the data instead of `data`; it may raise ServiceError."""
        self.writer: Callable[[bytes], None] | None = None
        """Accepts data that the master writes, within limits, instead of `data`; it may raise ServiceError."""
        self.watchers: list[Callable[[], None]] = []
        """Functions that are called after each write by the master."""
        self.data = self.encoded(value)

    @property
    def is_signed(self) -> bool:
        return self.attribute.format is Format.SIGNED

    def encoded(self, value: int | str | Iterable[int]) -> bytes:
        if isinstance(value, str):
            return value.encode("latin-1", "replace")[: self.largest]
        size = self.attribute.length.bytes
        numbers = (value,) if isinstance(value, int) else value
        if isinstance(value, int) and self.attribute.length.is_list:
            numbers = ()
        return b"".join((number & (1 << 8 * size) - 1).to_bytes(size, "little") for number in numbers)

    def decoded(self, data: bytes) -> list[int]:
        size = self.attribute.length.bytes
        starts = range(0, len(data) - size + 1, size)
        return [int.from_bytes(data[at : at + size], "little", signed=self.is_signed) for at in starts]

    @property
    def number(self) -> int:
        return int.from_bytes(self.present(), "little", signed=self.is_signed)

    @property
    def numbers(self) -> list[int]:
        return self.decoded(self.present())

    @property
    def text(self) -> str:
        return self.present().decode("latin-1")

    def shown(self, data: bytes) -> int | float | str:
        """Return data as people read them: with decimals, and a list as a text.  `data` has no lengths in front."""
        attribute = self.attribute
        if attribute.format is Format.TEXT:
            return data.decode("latin-1")
        numbers = self.decoded(data)
        if attribute.length.is_list:
            return " ".join(map(idn_text if attribute.format is Format.IDN else str, numbers))
        return numbers[0] / 10**attribute.decimals if attribute.decimals else numbers[0]

    def set(self, value: int | str | Iterable[int]) -> None:
        """Set the data from inside the drive, without limits or protection."""
        self.data = self.encoded(value)

    def present(self) -> bytes:
        return self.data if self.reader is None else self.reader()

    def element(self, element: Element) -> bytes:
        """Return an element as it is sent over the ring.  Raises ServiceError if it does not exist."""
        match element:
            case Element.IDN:
                return self.status.to_bytes(2, "little")
            case Element.NAME:
                return self._text(self.name, Code.NO_NAME)
            case Element.ATTRIBUTE:
                return self.attribute.word.to_bytes(4, "little")
            case Element.UNIT:
                return self._text(self.unit, Code.NO_UNIT)
            case Element.MINIMUM:
                return self._limit(self.minimum, Code.NO_MINIMUM)
            case Element.MAXIMUM:
                return self._limit(self.maximum, Code.NO_MAXIMUM)
            case Element.DATA:
                data = self.present()
                return led(data, self.largest) if self.attribute.length.is_list else data
        raise ServiceError(Code.WRONG_ACCESS)

    @staticmethod
    def _text(text: str, missing: Code) -> bytes:
        if not text:
            raise ServiceError(missing)
        return led(text.encode("latin-1", "replace"), len(text))

    def _limit(self, limit: int | None, missing: Code) -> bytes:
        if limit is None:
            raise ServiceError(missing)
        size = self.attribute.length.bytes
        return (limit & (1 << 8 * size) - 1).to_bytes(size, "little")

    def write(self, data: bytes, phase: int) -> None:
        """Write the data as received from the master.  Raises ServiceError with the reason for a refusal."""
        if self.attribute.protected == READ_ONLY:
            raise ServiceError(Code.READ_ONLY)
        if phase in self.attribute.protected:
            raise ServiceError(Code.PROTECTED_NOW)
        data = self._checked(data)
        if self.writer is not None:
            self.writer(data)
        else:
            self.data = data
        for watcher in self.watchers:
            watcher()

    def _checked(self, data: bytes) -> bytes:
        if self.attribute.length.is_list:
            return self._checked_list(data)
        size = self.attribute.length.bytes
        if len(data) != size:
            raise ServiceError(Code.TOO_SHORT if len(data) < size else Code.TOO_LONG)
        self._check_limits(self.decoded(data))
        return data

    def _checked_list(self, data: bytes) -> bytes:
        if len(data) < 4:
            raise ServiceError(Code.TOO_SHORT)
        actual = int.from_bytes(data[:2], "little")
        if actual > self.largest:
            raise ServiceError(Code.TOO_LONG)
        if len(data) < 4 + actual or actual % self.attribute.length.bytes:
            raise ServiceError(Code.TOO_SHORT)
        if len(data) > 4 + actual + actual % 2:  # a step transfers two bytes
            raise ServiceError(Code.TOO_LONG)
        data = data[4 : 4 + actual]
        if self.attribute.format is not Format.TEXT:
            self._check_limits(self.decoded(data))
        return data

    def _check_limits(self, numbers: list[int]) -> None:
        for number in numbers:
            if self.minimum is not None and number < self.minimum:
                raise ServiceError(Code.BELOW_MINIMUM)
            if self.maximum is not None and number > self.maximum:
                raise ServiceError(Code.ABOVE_MAXIMUM)


def led(data: bytes, largest: int) -> bytes:
    """Return a list or text with its actual and largest length in front."""
    return len(data).to_bytes(2, "little") + largest.to_bytes(2, "little") + data


class IdnTable:
    """The operation data of one drive."""

    def __init__(self, data: Iterable[Datum] = ()) -> None:
        self._data: dict[int, Datum] = {}
        self.cyclic: Container[int] = ()
        """IDNs in the MDT, from CP3 on."""
        for datum in data:
            self.add(datum)

    def add(self, datum: Datum) -> Datum:
        self._data[datum.idn] = datum
        return datum

    def __getitem__(self, idn: int) -> Datum:
        return self._data[idn]

    def __contains__(self, idn: object) -> bool:
        return idn in self._data

    def __iter__(self) -> Iterator[Datum]:
        return iter(self._data.values())

    def asked(self, idn: int) -> Datum:
        """Return the datum of an IDN.  Raises ServiceError if there is none."""
        datum = self._data.get(idn)
        if datum is None:
            raise ServiceError(Code.NO_IDN)
        return datum
