"""Properties in scenario files, with their conditions and times."""

from collections.abc import Iterator
from typing import Annotated, Any, Final, Self

from pydantic import Field, PlainValidator, model_validator

from fieldrig.settings import Settings, WrongKey, refuse_all
from fieldrig.text.durations import duration_ns
from fieldrig_devices.scenarios.expression import Expression, expression_of
from fieldrig_devices.scenarios.property import Kind, Property


def _duration(value: Any) -> int:
    if not isinstance(value, str):
        raise ValueError("expected a time with a unit, such as 100ms or 1.5s")
    return duration_ns(value)


def _expression(value: Any) -> Expression:
    if not isinstance(value, str):
        raise ValueError("expected an expression, such as tank/level > 1.5 and not pump/run")
    return expression_of(value)


Duration = Annotated[int, PlainValidator(_duration, json_schema_input_type=str)]
Condition = Annotated[Any, PlainValidator(_expression, json_schema_input_type=str)]


class PropertySettings(Settings):
    always: Condition = Field(default=None, description="a condition that is true all the time")
    never: Condition = Field(default=None, description="a condition that is never true")
    expect: Condition = Field(default=None, description="a condition that becomes true `within` a time")
    stays: Condition = Field(default=None, description="a condition that is true `until` another one is")
    eventually: Condition = Field(
        default=None, description="a condition that becomes true `within` a time, when all faults are over"
    )
    after: Condition = Field(
        default=None, description="from when on: each instant at which this becomes true; without it, the begin"
    )
    until: Condition = Field(default=None, description="the end of `stays`")
    within: Duration | None = Field(default=None, description="the longest time")
    longer: Duration | None = Field(
        default=None, description="the time for which `always` or `never` may be wrong, such as a delay of the program"
    )

    @model_validator(mode="after")
    def _is_one_property(self) -> Self:
        given = [name for name in _KINDS if getattr(self, name) is not None]
        if len(given) != 1:
            what = f"it has {' and '.join(given)}" if given else "it says nothing"
            raise ValueError(f"{what}: expected one of {', '.join(_KINDS)}")
        refuse_all(self._wrong(_KINDS[given[0]], given[0]))
        return self

    def _wrong(self, kind: Kind, name: str) -> Iterator[WrongKey]:
        if kind in (Kind.WITHIN, Kind.EVENTUALLY) and self.within is None:
            yield WrongKey(("within",), f"{name} needs a time", f"expected {{{name}: ..., within: 100ms}}")
        if kind is Kind.STAYS and self.until is None:
            yield WrongKey(("until",), "stays needs an end", "expected {stays: ..., until: ...}")
        if kind is not Kind.STAYS and self.until is not None:
            yield WrongKey(("until",), f"{name} has no end", "only `stays` has `until`")
        if kind in (Kind.ALWAYS, Kind.NEVER) and self.within is not None:
            yield WrongKey(("within",), f"{name} takes no time", "`expect` and `eventually` have `within`")
        if kind not in (Kind.ALWAYS, Kind.NEVER) and self.longer is not None:
            yield WrongKey(("longer",), f"{name} takes no such time", "`always` and `never` have `longer`")
        if kind is Kind.EVENTUALLY and self.after is not None:
            yield WrongKey(("after",), "eventually begins when all faults are over", "leave `after` out")

    def property(self, name: str) -> Property:
        key = next(one for one in _KINDS if getattr(self, one) is not None)
        longest_ns = self.longer if self.within is None else self.within
        return Property(name, _KINDS[key], getattr(self, key), self.after, self.until, longest_ns)


_KINDS: Final = {
    "always": Kind.ALWAYS,
    "never": Kind.NEVER,
    "expect": Kind.WITHIN,
    "stays": Kind.STAYS,
    "eventually": Kind.EVENTUALLY,
}
