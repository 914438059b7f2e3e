"""A YAML file of one settings model: every mistake is found in one run, each with its line."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from fieldrig.errors import ConfigError
from fieldrig.settings import Settings, WrongKey
from fieldrig.settings_file import load_settings


class Motor(Settings):
    poles: int
    speed: float = 0.0


class Motors(Settings):
    motors: list[Motor]


def check(found: Motors) -> Iterator[WrongKey]:
    for index, motor in enumerate(found.motors):
        if motor.poles % 2:
            yield WrongKey(("motors", index, "poles"), "poles come in pairs", "expected an even number")


def lines_of(tmp_path: Path, text: str) -> list[tuple[int | None, str]]:
    path = tmp_path / "motors.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as refused:
        load_settings(path, Motors, check)
    assert {mistake.file for mistake in refused.value.mistakes} == {str(path)}
    return [(mistake.line, mistake.key) for mistake in refused.value.mistakes]


def test_a_file_that_fits_is_read(tmp_path: Path) -> None:
    path = tmp_path / "motors.yaml"
    path.write_text("motors:\n- {poles: 4}\n", encoding="utf-8")
    assert load_settings(path, Motors, check) == Motors(motors=[Motor(poles=4)])


def test_every_mistake_has_its_line(tmp_path: Path) -> None:
    text = "motors:\n  - poles: four\n    speed: 1\n  - poles: 2\n    sped: 1\n"
    assert lines_of(tmp_path, text) == [(2, "motors[0].poles"), (5, "motors[1].sped")]


def test_a_key_that_is_missing_is_shown_where_it_belongs(tmp_path: Path) -> None:
    assert lines_of(tmp_path, "motors:\n  - poles: 2\n  - speed: 3\n") == [(3, "motors[1].poles")]
    assert lines_of(tmp_path, "") == [(None, "motors")]


def test_what_is_no_yaml_is_one_mistake_with_its_line(tmp_path: Path) -> None:
    assert [line for line, _ in lines_of(tmp_path, "motors:\n  - poles: 2\n - [")] == [3]


def test_a_check_of_the_whole_finds_its_lines(tmp_path: Path) -> None:
    assert lines_of(tmp_path, "motors:\n  - poles: 2\n  - poles: 3\n") == [(3, "motors[1].poles")]


def test_a_file_that_is_missing_or_not_text_is_refused(tmp_path: Path) -> None:
    for path, data in ((tmp_path / "missing.yaml", None), (tmp_path / "binary.yaml", b"\xff\xfe\x00")):
        if data is not None:
            path.write_bytes(data)
        with pytest.raises(ConfigError, match="it can't be read"):
            load_settings(path, Motors)
