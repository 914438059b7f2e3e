"""Objects of a `canopen.node` that live by themselves."""

from typing import Any

import pytest
from canopen_bench import IO32, CanopenBench
from pydantic import ValidationError

from fieldrig_devices.canopen.node import CanopenSettings

RAMP = {"kind": "ramp", "first": 0.0, "last": 1000.0, "period_ms": 1000.0, "every_ms": 10.0}
BIT = {"kind": "square", "low": 0.0, "high": 255.0, "period_ms": 40.0}


def test_a_pdo_is_sent_when_a_living_object_changes() -> None:
    """CiA 401: TPDO 1 carries the digital inputs of 6000h, and is sent when they change."""
    bench = CanopenBench(sources={"6000:01": BIT})
    bench.send("000#01 05")
    bench.take()
    changes = [frame for frame in bench.after(40) if frame.startswith("185")]
    assert [frame.split("#")[1].split()[0] for frame in changes] == ["00", "ff"]


def test_an_sdo_reads_the_present_value() -> None:
    bench = CanopenBench(sources={"6401:01": RAMP})
    bench.after(500)
    (answer,) = bench.send("605#40 01 64 01 00 00 00 00")
    assert answer == "585#4b 01 64 01 f4 01 00 00"  # 500


def test_a_reset_of_the_node_begins_again_and_one_of_communication_does_not() -> None:
    bench = CanopenBench(sources={"6401:01": RAMP})
    bench.after(300)
    bench.send("000#82 05")
    bench.after(200)
    assert bench.send("605#40 01 64 01 00 00 00 00")[0] == "585#4b 01 64 01 f4 01 00 00"  # 500
    bench.send("000#81 05")
    bench.after(100)
    assert bench.send("605#40 01 64 01 00 00 00 00")[0] == "585#4b 01 64 01 64 00 00 00"  # 100


def test_a_node_without_power_changes_nothing() -> None:
    bench = CanopenBench(sources={"6401:01": RAMP})
    bench.node.power_off()
    bench.after(500)
    assert bench.node.points()["6401:01"].read() == 0


@pytest.mark.parametrize(
    ("sources", "told"),
    [
        ({"7000:01": BIT}, "the EDS has no 7000:01"),
        ({"1008:00": BIT}, "expected an object that holds a number"),
        ({"six": BIT}, "is not an object"),
    ],
)
def test_wrong_objects_are_refused(sources: dict[str, Any], told: str) -> None:
    with pytest.raises(ValidationError, match=told):
        CanopenSettings.model_validate({"node_id": 5, "eds": str(IO32), "sources": sources})
