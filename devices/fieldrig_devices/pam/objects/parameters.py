"""Parameters of objects with a rule of their own, as attributes of their items."""

from collections.abc import Callable
from typing import Any

from fieldrig_devices.pam.objects.site import Site
from fieldrig_devices.pam.runtime.item import RoutineRef


class AboveZero:
    """A parameter that ignores values that are not above 0 (PAML-049)."""

    def __set_name__(self, _owner: type, name: str) -> None:
        self._name = f"_{name}"

    def __get__(self, item: object, _owner: type | None = None) -> float:
        value: float = getattr(item, self._name)
        return value

    def __set__(self, item: object, value: float) -> None:
        if value > 0:
            setattr(item, self._name, float(value))


class OfBlock:
    """A parameter that is an attribute of the item's block."""

    def __init__(self, attribute: str) -> None:
        self._attribute = attribute

    def __get__(self, item: Any, _owner: type | None = None) -> float:
        value: float | None = getattr(item.block, self._attribute)
        return value or 0.0

    def __set__(self, item: Any, value: float) -> None:
        setattr(item.block, self._attribute, float(value))


class PeriodOfBlock(OfBlock):
    """A period of the block, which those behind it take over; values that are not above 0 are ignored."""

    def __set__(self, item: Any, value: float) -> None:
        if value > 0:
            super().__set__(item, value)
            item.site.periods_changed()


class SlewedOfBlock:
    """A parameter that the block slews: it is read as it is now, and written by `set_...` of the block."""

    def __init__(self, slewed: str) -> None:
        self._slewed = slewed

    def __get__(self, item: Any, _owner: type | None = None) -> float:
        value: float = getattr(item.block, self._slewed).value
        return value

    def __set__(self, item: Any, value: float) -> None:
        getattr(item.block, f"set_{self._slewed}")(float(value))


class SlopeOfBlock:
    """The slope of a slewed parameter; MAX changes at once, and is read as infinite."""

    def __init__(self, slewed: str) -> None:
        self._slewed = slewed

    def __get__(self, item: Any, _owner: type | None = None) -> float:
        slope: float | None = getattr(item.block, self._slewed).slope
        return float("inf") if slope is None else slope

    def __set__(self, item: Any, value: float | str | None) -> None:
        getattr(item.block, self._slewed).slope = float(value) if isinstance(value, int | float) else None


class StartedRoutine:
    """A routine that an attribute of `part` starts, the item's block or trace (PAML-273)."""

    def __init__(self, part: str, attribute: str) -> None:
        self._part, self._attribute = part, attribute

    def __get__(self, item: Any, _owner: type | None = None) -> Any:
        return getattr(getattr(item, self._part), self._attribute)

    def __set__(self, item: Any, routine: RoutineRef) -> None:
        setattr(getattr(item, self._part), self._attribute, starter(routine, item.site))


def starter(routine: RoutineRef, site: Site) -> Callable[[], None]:
    """Return what starts a routine; NONE starts nothing."""
    if not routine.routine:
        return lambda: None
    return lambda: site.kernel.start_routine(routine)
