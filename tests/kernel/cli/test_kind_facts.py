"""The facts of a kind of bus or device: its links, settings with limits in words, and faults."""

from typing import Annotated

import pytest
from pydantic import Field
from typer import BadParameter

from fieldrig.cli.kind_facts import facts_of, settings_of, without
from fieldrig.settings import Settings


class Limited(Settings):
    free: int = 3
    both: int = Field(ge=1, le=127)
    or_none: int | None = Field(default=None, ge=0, le=9)
    low: float = Field(default=1.0, ge=0.5)
    above: float = Field(gt=0)
    above_to: float = Field(gt=0, le=1)
    high: int = Field(le=5)
    below: float = Field(lt=2)
    from_below: float = Field(ge=-1, lt=2)
    between: float = Field(gt=-1, lt=2)
    of_two: Annotated[int, Field(ge=1)] | Annotated[str, Field(min_length=1)] = 1


def test_limits_are_words() -> None:
    assert {key: of["limits"] for key, of in settings_of(Limited).items()} == {
        "free": "", "both": "1 to 127", "or_none": "0 to 9", "low": "0.5 or more", "above": "above 0",
        "above_to": "above 0, to 1", "high": "5 or less", "below": "below 2", "from_below": "from -1, below 2",
        "between": "between -1 and 2", "of_two": "",
    }  # fmt: skip


def test_a_default_is_as_a_rig_file_has_it() -> None:
    settings = settings_of(Limited)
    assert [without(settings[key]) for key in ("free", "both", "or_none", "low")] == ["3", "needed", "", "1.0"]


def test_facts_of_a_device_and_a_bus_have_links_settings_and_faults() -> None:
    node, bus = facts_of("canopen.node"), facts_of("can.virtual")
    assert (node["sort"], bus["sort"], [*node["links"]], bus["links"]) == ("device", "bus", ["can", "wires"], {})
    assert node["faults"]["sdo_delay"].startswith("index= subindex= ")
    assert bus["settings"]["bitrate"]["type"] == "integer"


def test_an_unknown_kind_is_answered_with_the_nearest() -> None:
    with pytest.raises(BadParameter, match=r"did you mean canopen\.node"):
        facts_of("canopen.nod")
