"""JSON for programs that are not ours."""

import json
from math import inf, nan
from typing import Any

import pytest

from fieldrig.text.strict_json import strict_json


def refused(name: str) -> Any:
    raise AssertionError(f"{name} is no JSON")


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ({"a": nan, "b": [inf, (-inf, 1.5)]}, {"a": "nan", "b": ["inf", ["-inf", 1.5]]}),
        (nan, "nan"),
        ({"a": [1, None, True, "nan"]}, {"a": [1, None, True, "nan"]}),
    ],
)
def test_numbers_that_json_does_not_have_are_words(value: Any, words: Any) -> None:
    assert json.loads(strict_json(value), parse_constant=refused) == words


def test_other_characters_stay_or_are_escapes() -> None:
    assert (strict_json("ü"), strict_json("ü", ensure_ascii=True)) == ('"ü"', '"\\u00fc"')
