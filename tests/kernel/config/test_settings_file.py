"""A device's own file: every mistake in it comes with file, line, key, and what was expected."""

from collections.abc import Iterator
from pathlib import Path
from typing import Literal, Self

import pytest
from pydantic import Field, ValidationError, model_validator

from fieldrig.config.settings_file import load_settings, settings_of
from fieldrig.config.wording import explain
from fieldrig.config.yaml_source import Source
from fieldrig.errors import ConfigError, Mistake
from fieldrig.settings import ConfigFile, Settings, WrongKey


class Channel(Settings):
    name: str
    gain: float = Field(default=1, gt=0)


class Span(Settings):
    low: float
    high: float

    @model_validator(mode="after")
    def _is_ordered(self) -> Self:
        if self.low > self.high:
            raise ValueError("low is above high")
        return self


class Card(Settings):
    mode: Literal["fast", "slow"] = "slow"
    channels: tuple[Channel, ...] = ()
    table: ConfigFile | None = None
    span: Span | None = Field(default=None, description="where it measures")
    spans: tuple[Span, ...] | None = None


def twice(card: Card) -> Iterator[WrongKey]:
    names = [channel.name for channel in card.channels]
    for index, name in enumerate(names):
        if name in names[:index]:
            yield WrongKey(("channels", index, "name"), f"{name} is used twice", "expected a name of its own")


def mistakes(path: Path) -> list[Mistake]:
    with pytest.raises(ConfigError) as refused:
        load_settings(path, Card, twice)
    return refused.value.mistakes


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "card.yaml"


def test_a_file_becomes_settings_and_its_paths_are_relative_to_it(file: Path) -> None:
    file.with_name("t.yaml").write_text("")
    file.write_text("mode: fast\ntable: t.yaml\nchannels:\n  - {name: a, gain: 2}\n", encoding="utf-8")
    card = load_settings(file, Card, twice)
    assert card == Card(mode="fast", channels=(Channel(name="a", gain=2.0),), table=file.with_name("t.yaml").resolve())


def test_an_empty_file_has_no_keys(file: Path) -> None:
    file.write_text("# nothing yet\n", encoding="utf-8")
    assert load_settings(file, Card) == Card()


def test_every_mistake_is_reported_with_its_line(file: Path) -> None:
    file.write_text("mode: quick\nchannels:\n  - name: a\n    gain: 0\n  - gain: 1\ncolour: red\n", encoding="utf-8")
    found = mistakes(file)
    assert [(item.file, item.line, item.key) for item in found] == [
        (str(file), 1, "mode"),
        (str(file), 4, "channels[0].gain"),
        (str(file), 5, "channels[1].name"),
        (str(file), 6, "colour"),
    ]
    assert "fast or slow" in found[0].remedy


def test_conflicts_are_reported_once_the_entries_are_right(file: Path) -> None:
    file.write_text("channels:\n  - {name: a}\n  - name: a\n", encoding="utf-8")
    assert mistakes(file) == [
        Mistake(str(file), 3, "channels[1].name", "a is used twice", "expected a name of its own")
    ]


@pytest.mark.parametrize(
    ("content", "what"),
    [(b"mode: [", "not YAML"), (b"\xff", "it is not UTF-8 text"), (b"- mode", "doesn't fit"), (None, "cannot be read")],
)
def test_a_file_that_is_none_is_one_mistake(file: Path, content: bytes | None, what: str) -> None:
    if content is not None:
        file.write_bytes(content)
    (mistake,) = mistakes(file)
    assert mistake.file == str(file)
    assert what in mistake.what


def test_data_from_elsewhere_is_checked_the_same_way() -> None:
    with pytest.raises(ConfigError, match="mode"):
        settings_of(Source({"mode": 1}), Card)


@pytest.mark.parametrize("text", ["span: {low: 2, high: 1}", "spans: [{low: 2, high: 1}]"])
def test_what_is_wrong_with_a_whole_mapping_has_no_remedy_of_its_type(tmp_path: Path, text: str) -> None:
    (tmp_path / "card.yaml").write_text(text)
    (mistake,) = mistakes(tmp_path / "card.yaml")
    assert (mistake.what, mistake.remedy) == ("low is above high", "")


class Lengths(Settings):
    least_one: str = Field(default="x", min_length=1)
    least_two: str = Field(default="xx", min_length=2)
    most: str = Field(default="", max_length=1)
    between: str = Field(default="x", min_length=1, max_length=4)
    exact: tuple[int, ...] = Field(default=(0, 0), min_length=2, max_length=2)
    list_of_most: tuple[int, ...] = Field(default=(), max_length=1)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("least_one: ''", "a text of at least 1 character"),
        ("least_two: ''", "a text of at least 2 characters"),
        ("most: abc", "a text of at most 1 character"),
        ("between: abcde", "a text of 1 to 4 characters"),
        ("exact: [1]", "a list of 2 items"),
        ("list_of_most: [1, 2]", "a list of at most 1 item"),
    ],
)
def test_lengths_are_said_as_a_person_says_them(file: Path, text: str, expected: str) -> None:
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as refused:
        load_settings(file, Lengths)
    assert [mistake.remedy for mistake in refused.value.mistakes] == [f"expected {expected}"]


class _Counted(str):
    """A key that counts how often it is looked at in words."""

    looks = 0

    def __str__(self) -> str:
        _Counted.looks += 1
        return str.__str__(self)


def test_many_wrong_keys_are_explained_in_linear_time() -> None:
    _Counted.looks = 0
    data = {_Counted(f"key{number}"): number for number in range(500)}
    with pytest.raises(ValidationError) as refused:
        Card.model_validate(data)
    wrong = explain(refused.value, data, Card)
    assert [mistake.path for mistake in wrong] == [(f"key{number}",) for number in range(500)]
    assert _Counted.looks <= 10 * len(data)
