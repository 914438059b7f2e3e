"""YAML 1.2 (core schema, chapter 10.3) as a rig file has it, and where its keys stand."""

import math
from pathlib import Path
from typing import Any

import pytest

from fieldrig.config.yaml_source import Mark, key_text, read, read_file


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("010", 10),
        ("0x1F", 31),
        ("0o17", 15),
        ("-5", -5),
        ("1_000", 1000),
        ("1e3", 1000.0),
        (".5", 0.5),
        ("-.inf", -math.inf),
        ("true", True),
        ("False", False),
        ("on", "on"),
        ("no", "no"),
        ("~", None),
        ("", None),
        ("12:30", "12:30"),
        ("2026-11-21", "2026-11-21"),
        ("'7'", "7"),
        ("!!str 7", "7"),
        ("0x", "0x"),
        ("9" * 200, "9" * 200),
        ("[1, [a], {b: 2}]", [1, ["a"], {"b": 2}]),
    ],
)
def test_a_value_is_what_yaml_1_2_says(text: str, value: Any) -> None:
    source = read(f"key: {text}", "f")
    assert source.mistakes == []
    found = source.data["key"]
    assert (found, type(found)) == (value, type(value))


def test_keys_may_be_numbers() -> None:
    assert read("1: a\n'2': b", "f").data == {1: "a", "2": "b"}


def test_a_merge_key_adds_what_is_not_there_yet() -> None:
    source = read("a: &a {x: 1, y: 1}\nb: &b {y: 2, z: 2}\nc: {x: 0, <<: [*a, *b]}\n", "f")
    assert source.data["c"] == {"x": 0, "y": 1, "z": 2}
    assert source.mark(("c", "x")).line == 3
    assert source.mark(("c", "z")).line == 2


@pytest.mark.parametrize(
    ("text", "mistake"),
    [
        ("a: 1\nb: {c: 1,\n  c: 2}", "f:3: b.c: the same key is in line 2\n    keep one of the two"),
        ("a: !Press 1", "f:1: a: the tag !Press has no meaning here\n    take it away"),
        ("a: !!set {}", "f:1: a: the tag tag:yaml.org,2002:set has no meaning here\n    take it away"),
        ("? [a]\n: 1", "f:1: a key is a name or a whole number\n    expected quotes around it"),
        ("1.5: a", "f:1: a key is a name or a whole number\n    expected quotes around it"),
        ("<<: 5", "f:1: << takes a mapping\n    expected `<<: *name` with an anchored mapping"),
        ('a: "\\ud800"', "f:1: a: half of a surrogate pair is not a character\n    expected \\U and 8 digits"),
    ],
)
def test_what_has_no_place_in_a_rig_file_is_refused(text: str, mistake: str) -> None:
    assert [str(found) for found in read(text, "f").mistakes] == [mistake]


@pytest.mark.parametrize(
    "text", ["a: [", "a: b: c", "\ta", "%YAML 3.0\n---\na", "a\n---\nb", '"\\UFFFFFFFF"', "*a", "\0"]
)
def test_what_is_not_yaml_is_a_mistake(text: str) -> None:
    (mistake,) = read(text, "f").mistakes
    assert mistake.what.startswith("this is not YAML: ")


def test_every_key_and_item_has_its_line() -> None:
    source = read("a:\n  b:\n  - 1\n  - c: 2\n", "f")
    assert source.mark(("a", "b", 1, "c")) == Mark("f", 4)
    assert source.mark(("a", "b", 0)) == Mark("f", 3)


def test_a_key_that_is_not_there_stands_where_it_would_go() -> None:
    source = read("x: 1\na:\n  b: 1\n", "f")
    assert source.mark(("a", "c")) == Mark("f", 2)
    assert source.mark(("z",)) == Mark("f", 1)


def test_a_path_reads_as_it_would_be_typed() -> None:
    assert key_text(("devices", "io", "signals", 2, "wire")) == "devices.io.signals[2].wire"


def test_a_folder_instead_of_a_file_says_which_files_it_has(tmp_path: Path) -> None:
    (tmp_path / "b.yaml").touch()
    (tmp_path / "a.yaml").touch()
    (mistake,) = read_file(tmp_path).mistakes
    assert (mistake.what, mistake.remedy) == (
        "it is a folder, not a file",
        f"name files in it, such as {tmp_path / 'a.yaml'}",
    )


def test_a_folder_without_rig_files_names_none(tmp_path: Path) -> None:
    (mistake,) = read_file(tmp_path).mistakes
    assert (mistake.what, mistake.remedy) == ("it is a folder, not a file", "")


def test_equal_texts_are_read_apart() -> None:
    text = "drive: {gain: 1}"
    first, second = read(text, "a.yaml"), read(text, "b.yaml")
    first.data["drive"]["gain"] = 2
    assert second.data == read(text, "c.yaml").data == {"drive": {"gain": 1}}
    assert (first.mark(("drive",)).file, second.mark(("drive",)).file) == ("a.yaml", "b.yaml")


def test_only_aliases_make_more_values_than_a_text_has_characters(monkeypatch: pytest.MonkeyPatch) -> None:
    """A table of all 65,536 registers has more values than the limit, and each of them was typed."""
    monkeypatch.setattr("fieldrig.config.yaml_source.LARGEST", 10)
    assert read("[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]", "f").data == list(range(1, 13))
    (mistake,) = read("a: &a [1, 1, 1, 1, 1]\nb: &b [*a, *a, *a, *a]\nc: [*b, *b, *b]\n", "f").mistakes
    assert "its aliases stand for more than 61 values" in mistake.what
