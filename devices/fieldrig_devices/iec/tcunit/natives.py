"""The native functions behind the library TcUnit: they hand what a suite does to the session."""

import math
from collections.abc import Callable, Hashable, Sequence
from functools import partial
from itertools import product
from typing import Final

from fieldrig_devices.iec import any_types
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.host import Library, NativeFunction, Results
from fieldrig_devices.iec.memory import Memory
from fieldrig_devices.iec.tcunit import forms, library
from fieldrig_devices.iec.tcunit.session import Session
from fieldrig_devices.iec.types import Value
from fieldrig_devices.languages.faults import RunError

COST_NS: Final = 1_000
LEFT_OUT: Final = "the run has reached what does not compile"
"""The beginning of the fault of code that was left out."""
_LENGTHS: Final = {"STRING": "LEN", "WSTRING": "WLEN"}
_UNPRINTABLE: Final = "Not possible to print {} unicode WSTRING value"


class Natives:
    """The functions for one session.  `memory` is that of the program, once it is loaded."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.memory: Memory | None = None

    def library(self) -> Library:
        """Return the library with its text and its functions."""
        session = self._session
        functions: dict[str, Callable[..., Results]] = {
            "test": _nothing(session.test),
            "test_ordered": lambda name: (session.test_ordered(name),),
            "test_finished": lambda: (session.finished(),),
            "test_finished_named": _nothing(session.finished_named),
            "is_test_finished": lambda name: (session.is_finished(name),),
            "tcunit_adslogstr": self._log,
            "tcunit_native_cycle": _nothing(session.begin_cycle),
            "tcunit_native_following": lambda: (session.following(),),
            "tcunit_native_register": _nothing(session.register),
            "tcunit_native_are_finished": lambda suite: (session.are_tests_finished(suite),),
            "tcunit_native_any": self._any,
            "f_checkmemoryarea": self._memory_area,
            library.LEFT_OUT.lower(): _left_out,
        }
        for name, kind in library.SCALARS.items():
            functions[library.native_name(name).lower()] = partial(self._scalar, name, kind)
        for kind in library.REALS:
            functions[library.native_name(kind.name).lower()] = partial(self._real, kind)
        for name in library.TEXTS:
            functions[library.native_name(name).lower()] = partial(self._text, name)
        for _, kind, dimensions in library.array_asserts():
            function = partial(self._array, kind, dimensions)
            functions[library.native_name(kind.name, dimensions).lower()] = function
        natives = {name: NativeFunction(run, COST_NS) for name, run in functions.items()}
        return Library(library.FILE, library.text(), natives, {})

    def _log(self, mask: int, text: str, argument: str) -> Results:
        self._session.say(text.replace("%s", argument, 1))
        return ()

    def _memory_area(self, address: int, size: int) -> Results:
        """Return the value of E_TcMemoryArea for some bytes: 1 for variables of the program, 2 for those of __NEW."""
        memory = self.memory
        assert memory is not None, "a function of the library runs in a program"
        if memory.is_allocated(address, size):
            return (2,)
        return (int(memory.is_of_program(address, size)),)

    # ---- scalars

    def _scalar(self, name: str, kind: Elementary, suite: int, expected: Value, actual: Value, message: str) -> Results:
        if self._session.is_asserting(suite):
            write = forms.writer(kind)
            texts = None if expected == actual else lambda: (write(expected), write(actual))
            self._session.check(suite, name, (name, expected, actual), texts, message)
        return ()

    def _real(
        self, kind: Elementary, suite: int, expected: float, actual: float, delta: float, message: str
    ) -> Results:
        if self._session.is_asserting(suite):
            write = forms.writer(kind)
            texts = (lambda: (write(expected), write(actual))) if _differ(expected, actual, delta) else None
            self._session.check(suite, kind.name, (kind, _bits(expected), _bits(actual)), texts, message)
        return ()

    def _text(self, name: str, suite: int, expected: str, actual: str, message: str) -> Results:
        if self._session.is_asserting(suite):
            texts = None if expected == actual else lambda: _texts(name, expected, actual)
            shown = (expected, actual) if name == "WSTRING" else None
            self._session.check(suite, name, (name, expected, actual), texts, message, shown=shown)
        return ()

    # ---- arrays

    def _array(self, kind: Elementary, dimensions: int, suite: int, *given: Value) -> Results:
        """Compare two arrays; each is given by its limits and its address, a tolerance and the message follow."""
        if not self._session.is_asserting(suite):
            return ()
        size = 2 * dimensions + 1
        expecteds, actuals, rest = given[:size], given[size : 2 * size], given[2 * size :]
        message, delta = str(rest[-1]), float(rest[0]) if kind.is_real else 0.0
        title = f"Array{f'{dimensions}D' if dimensions > 1 else ''}_{kind.name}"
        limits = [_limits(one, dimensions) for one in (expecteds, actuals)]
        counts = [tuple(high - low + 1 for low, high in one) for one in limits]
        key: Hashable = (title, math.prod(counts[0]), math.prod(counts[1]))
        if counts[0] != counts[1]:
            sizes = forms.of_size(limits[0]), forms.of_size(limits[1])
            self._session.check(suite, title, key, lambda: sizes, message, ", size of arrays not matching.")
            return ()
        addresses = int(expecteds[-1]), int(actuals[-1])
        found = self._difference(kind, addresses, counts[0], delta)
        texts = None if found is None else lambda: self._elements(kind, limits, found)
        self._session.check(suite, title, key, texts, message)
        return ()

    def _difference(
        self, kind: Elementary, addresses: tuple[int, int], counts: Sequence[int], delta: float
    ) -> tuple[tuple[int, ...], Value, Value] | None:
        """Return the place of the first difference, from 0, and both values; None if there is none."""
        assert self.memory is not None
        cells = self.memory.cells
        for number, place in enumerate(product(*map(range, counts))):
            # Both have elements of this type, which the checker has made sure of.
            expected, actual = (cells[address + number * kind.size] for address in addresses)
            is_other = _differ(float(expected), float(actual), delta) if kind.is_real else expected != actual
            if is_other:
                return place, expected, actual
        return None

    def _elements(
        self, kind: Elementary, limits: Sequence[forms.Bounds], found: tuple[tuple[int, ...], Value, Value]
    ) -> tuple[str, str]:
        place, *values = found
        write = forms.writer(kind)
        made = []
        for bounds, value in zip(limits, values, strict=True):
            indexes = [low + offset for (low, _), offset in zip(bounds, place, strict=True)]
            made.append(forms.of_element(indexes, write(value)))
        return made[0], made[1]

    def _value(self, address: int, kind: Elementary) -> Value:
        assert self.memory is not None
        return self.memory.value_of(address, kind)

    # ---- ANY

    def _any(self, suite: int, expected: Sequence[Value], actual: Sequence[Value], message: str) -> Results:
        if not self._session.is_asserting(suite):
            return ()
        one, other = any_types.Described.of(expected), any_types.Described.of(actual)
        elementary = any_types.ELEMENTARY.get(one.type_class)
        if one.type_class != other.type_class:
            texts = f"(Type class = {one.class_name})", f"(Type class = {other.class_name})"
            return self._any_failed(suite, one, other, texts, message)
        if one.type_class in (any_types.STRING, any_types.WSTRING):
            return self._any_text(suite, one, other, message)
        if one.size != other.size:
            texts = f"(Data size = {one.size})", f"(Data size = {other.size})"
            return self._any_failed(suite, one, other, texts, message)
        if elementary is not None:
            values = [self._value(each.address, elementary) for each in (one, other)]
            if elementary.is_real:
                return self._real(elementary, suite, float(values[0]), float(values[1]), 0.0, message)
            name = next((long for long, kind in library.LONG_NAMES.items() if kind is elementary), elementary.name)
            return self._scalar(name, elementary, suite, values[0], values[1], message)
        data = self._bytes(one), self._bytes(other)
        is_same = data[0] == data[1]
        shown = None if is_same else (forms.of_bytes(data[0]), forms.of_bytes(data[1]))
        return self._any_failed(suite, one, other, shown, message)

    def _any_text(self, suite: int, one: any_types.Described, other: any_types.Described, message: str) -> Results:
        name = "WSTRING" if one.type_class == any_types.WSTRING else "STRING"
        assert self.memory is not None
        texts = [self.memory.text_of(each.address, is_wide=name == "WSTRING") for each in (one, other)]
        if len(texts[0]) == len(texts[1]):
            return self._text(name, suite, texts[0], texts[1], message)
        sizes = [f"(Data size ({_LENGTHS[name]}) = {len(text)})" for text in texts]
        return self._any_failed(suite, one, other, (sizes[0], sizes[1]), message)

    def _any_failed(
        self,
        suite: int,
        one: any_types.Described,
        other: any_types.Described,
        texts: tuple[str, str] | None,
        message: str,
    ) -> Results:
        key = ("ANY", *((each.type_class, self._bytes(each)) for each in (one, other)))
        self._session.check(suite, "ANY", key, (lambda: texts) if texts is not None else None, message)
        return ()

    def _bytes(self, one: any_types.Described) -> bytes:
        assert self.memory is not None
        return self.memory.bytes_at(one.address, one.size) if one.size else b""


def _left_out(reason: str) -> Results:
    raise RunError("left out", f"{LEFT_OUT}: {reason}")


def _nothing(function: Callable[..., None]) -> Callable[..., Results]:
    """Return a native function without a result."""

    def run(*arguments: Value) -> Results:
        function(*arguments)
        return ()

    return run


def _differ(expected: float, actual: float, delta: float) -> bool:
    """True if two numbers are further apart than a tolerance; NaN never is."""
    return abs(expected - actual) > delta


def _bits(value: float) -> Hashable:
    """Return what tells two numbers apart, so that NaN is the same as itself."""
    return "NaN" if math.isnan(value) else value


def _texts(name: str, expected: str, actual: str) -> tuple[str, str]:
    if name == "WSTRING":
        return _UNPRINTABLE.format("EXP"), _UNPRINTABLE.format("ACT")
    return expected, actual


def _limits(given: Sequence[Value], dimensions: int) -> forms.Bounds:
    return [(int(given[2 * n]), int(given[2 * n + 1])) for n in range(dimensions)]
