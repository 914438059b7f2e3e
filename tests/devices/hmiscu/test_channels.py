"""The configuration of the channels: values, limits and defaults of the manual's tables."""

from typing import Any

import pytest
from pydantic import ValidationError

from fieldrig.config.wording import explain
from fieldrig_devices.hmiscu.channels import Channels
from fieldrig_devices.hmiscu.pto.settings import PtoSettings, converted
from fieldrig_devices.hmiscu.pwm.settings import PwmSettings

PTO, PWM = {"mode": "pto"}, {"mode": "pwm"}

# Key, smallest, largest, default (manual 415 to 440).
RANGES = [
    pytest.param("start_frequency_hz", 0, 50_000, 0, marks=pytest.mark.manual("SCU-020")),
    pytest.param("stop_frequency_hz", 0, 50_000, 0, marks=pytest.mark.manual("SCU-021")),
    pytest.param("maximum_frequency_hz", 1, 50_000, 50_000, marks=pytest.mark.manual("SCU-022", "SCU-005")),
]
# Unit, then the largest value of all three ramps, then the defaults of acceleration, deceleration and fast stop.
RAMPS = [("ms", 49_999, (20, 20, 100)), ("Hz/ms", 50_000, (2500, 2500, 500))]


def mistakes(model: Any, data: dict[str, Any]) -> dict[str, str]:
    """Return what is refused: the remedy by the key."""
    with pytest.raises(ValidationError) as refused:
        model.model_validate(data)
    return {".".join(map(str, wrong.path)): wrong.remedy for wrong in explain(refused.value, data, model)}


@pytest.mark.parametrize(("key", "smallest", "largest", "default"), RANGES)
def test_a_frequency_has_the_range_and_default_of_the_manual(
    key: str, smallest: int, largest: int, default: int
) -> None:
    assert getattr(PtoSettings.model_validate(PTO), key) == default
    for value in (smallest, largest):
        assert getattr(PtoSettings.model_validate(PTO | {key: value}), key) == value
    for value in (smallest - 1, largest + 1):
        assert list(mistakes(PtoSettings, PTO | {key: value})) == [key]


@pytest.mark.manual("SCU-014", "SCU-015", "SCU-016")
@pytest.mark.parametrize(("unit", "largest", "defaults"), RAMPS)
def test_ramps_have_the_range_and_defaults_of_their_unit(
    unit: str, largest: int, defaults: tuple[int, int, int]
) -> None:
    with_unit = PTO | {"ramp_unit": unit}
    assert PtoSettings.model_validate(with_unit).limits == defaults
    for position, key in enumerate(("acceleration_max", "deceleration_max", "fast_stop")):
        for value in (1, largest):
            assert PtoSettings.model_validate(with_unit | {key: value}).limits[position] == value
        for value in (0, largest + 1):
            assert list(mistakes(PtoSettings, with_unit | {key: value})) == [key]


@pytest.mark.manual("SCU-012", "SCU-013", "SCU-023", "SCU-024")
def test_choices_have_the_defaults_of_the_manual() -> None:
    settings = PtoSettings.model_validate(PTO)
    assert (settings.output_mode, settings.ramp_unit) == ("pulse/direction", "ms")
    assert (settings.aux, settings.aux_filter_ms) == ("not_used", 3)
    assert PtoSettings.model_validate(PTO | {"aux_filter_ms": 12}).aux_filter_ms == 12
    for wrong in ({"aux_filter_ms": 5}, {"aux": "origin"}, {"output_mode": "clock"}, {"ramp_unit": "s"}):
        assert list(mistakes(PtoSettings, PTO | wrong)) == list(wrong)


@pytest.mark.manual("SCU-013")
@pytest.mark.parametrize(("ms", "hz_per_ms"), [(20, 2500), (100, 500)])
def test_a_change_of_the_unit_converts_the_ramps(ms: int, hz_per_ms: int) -> None:
    assert converted(ms, 50_000, 50_000) == hz_per_ms
    assert converted(hz_per_ms, 50_000, 49_999) == ms


def test_a_start_frequency_above_the_maximum_is_refused_with_the_range() -> None:
    wrong = mistakes(PtoSettings, PTO | {"maximum_frequency_hz": 1000, "start_frequency_hz": 1001})
    assert wrong == {"start_frequency_hz": "expected 0 to 1000 (maximum_frequency_hz)"}


# Channel 0, channel 1, and the names of the instances; None if it is refused (manual 374 to 378, 1585 to 1587).
PAIRS: list[tuple[dict[str, str], dict[str, str], tuple[str | None, str | None] | None]] = [
    ({}, {}, (None, None)),
    ({}, PWM, (None, "PWM01")),
    (PTO, {}, ("PTO00", None)),
    (PWM, {}, ("PWM00", None)),
    (PWM, PWM, ("PWM00", "PWM01")),
    (PTO, PWM, None),
    ({}, PTO, None),
    (PWM, PTO, None),
]


@pytest.mark.manual("SCU-001", "SCU-002", "SCU-003", "SCU-004", "SCU-010", "SCU-011")
@pytest.mark.parametrize(("first", "second", "names"), PAIRS)
def test_channels_exclude_each_other_as_the_manual_says(
    first: dict[str, str], second: dict[str, str], names: tuple[str | None, str | None] | None
) -> None:
    data = {f"channel_{number}": use for number, use in enumerate((first, second)) if use}
    if names is not None:
        assert Channels.model_validate(data).variables == names
    else:
        assert list(mistakes(Channels, data)) == ["channel_1.mode"]


@pytest.mark.manual("SCU-010")
def test_an_instance_can_be_renamed_but_not_twice_to_the_same_name() -> None:
    feed = PWM | {"variable": "Feed"}
    assert Channels.model_validate({"channel_0": feed, "channel_1": PWM}).variables == ("Feed", "PWM01")
    assert list(mistakes(Channels, {"channel_0": feed, "channel_1": PWM | {"variable": "FEED"}})) == [
        "channel_1.variable"
    ]


def test_the_mode_that_the_manual_does_not_describe_is_refused() -> None:
    assert list(mistakes(Channels, {"channel_0": {"mode": "frequency_generator"}})) == ["channel_0.mode"]


@pytest.mark.manual("SCU-073")
def test_pwm_inputs_have_the_choices_and_defaults_of_the_manual() -> None:
    settings = PwmSettings.model_validate(PWM)
    assert (settings.enable_input, settings.enable_filter_ms) == (False, 3)
    assert (settings.sync_input, settings.sync_filter_ms, settings.sync_edge) == (False, 3, "rising")
    assert [PwmSettings.model_validate(PWM | {"sync_edge": edge}).sync_edge for edge in ("falling", "both")] == [
        "falling",
        "both",
    ]
    for wrong in ({"enable_filter_ms": 4}, {"sync_filter_ms": 0}, {"sync_edge": "none"}):
        assert list(mistakes(PwmSettings, PWM | wrong)) == list(wrong)
