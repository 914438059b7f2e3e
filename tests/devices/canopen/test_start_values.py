"""Power-on values of a node that no master could write (CiA 301, 7.5.2) are refused at their key."""

from typing import Any

import pytest
from canopen_bench import CanopenBench
from pydantic import ValidationError

HEARTBEAT = 0x0010_0064
"""Node 16, 100 ms."""


@pytest.mark.parametrize(
    ("objects", "wrong", "told"),
    [
        ({"1029:01": 3}, "1029:01", "at most 2"),
        ({"1400:02": 241}, "1400:02", "transmission type of an RPDO"),
        ({"1800:02": 251}, "1800:02", "transmission type of a TPDO"),
        ({"1800:01": 0x581}, "1800:01", "a COB-ID that no other service has"),
        ({"1800:01": 0x1_0185}, "1800:01", "11 bits or bit 29 set"),
        ({"1016:01": HEARTBEAT, "1016:02": HEARTBEAT + 1}, "1016:02", "a node-ID that no other sub-index has"),
    ],
)
def test_a_value_that_the_node_would_refuse(objects: dict[str, int], wrong: str, told: str) -> None:
    with pytest.raises(ValidationError) as refused:
        CanopenBench(objects=objects)
    (error,) = refused.value.errors()
    assert told in {key.path: f"{key.what}; {key.remedy}" for key in error["ctx"]["error"].wrong}["objects", wrong]


@pytest.mark.parametrize(
    "objects",
    [
        {"1029:01": 2}, {"1400:02": 240}, {"1800:02": 252}, {"1800:01": 0x8000_0581}, {"1800:01": 0x2001_0185},
        {"1016:01": HEARTBEAT, "1016:02": 0x0011_0064}, {"1016:01": HEARTBEAT, "1016:02": 0x0010_0000},
    ],
)  # fmt: skip
def test_a_value_that_it_would_take(objects: dict[str, Any]) -> None:
    bench = CanopenBench(objects=objects)
    assert {key: bench.node.dictionary.by_key(key).number for key in objects} == objects
