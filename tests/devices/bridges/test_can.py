import pytest
from pydantic import ValidationError

from fieldrig.testing import RecordedLink
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.bridges.can import CanBridge, CanBridgeSettings

FRAME = CanFrame(0x123, b"\x01\x02")
OTHER = CanFrame(0x1234567, is_extended=True)


class Bench:
    def __init__(self, settings: CanBridgeSettings) -> None:
        self.a, self.b = RecordedLink[CanFrame](), RecordedLink[CanFrame]()
        self.bridge = CanBridge(self.a, self.b, settings)

    def counted(self) -> dict[str, object]:
        return {key: point.read() for key, point in self.bridge.points().items()}


@pytest.fixture
def bench() -> Bench:
    return Bench(CanBridgeSettings())


def test_it_carries_every_frame_both_ways(bench: Bench) -> None:
    bench.a.deliver(FRAME)
    bench.b.deliver(OTHER)
    bench.a.deliver(OTHER)
    assert bench.b.sent == [FRAME, OTHER]
    assert bench.a.sent == [OTHER]
    assert bench.counted() == {"a_to_b": 2, "b_to_a": 1}


def test_it_hears_everything_unless_told_otherwise(bench: Bench) -> None:
    assert bench.a.interest is None
    assert bench.b.interest is None


def test_each_direction_has_filters_of_its_own() -> None:
    bench = Bench(CanBridgeSettings.model_validate({"a_to_b": [[0x180, 0x780], [0, 0x7FF]], "b_to_a": []}))
    assert bench.a.interest == [[0x180, 0x780], [0, 0x7FF]]
    assert bench.b.interest == []


@pytest.mark.parametrize("filters", [[[1]], [[1, 2, 3]], [[-1, 0]], [[0, 0x1_0000_0000]], [1, 2], ["own"]])
def test_what_is_no_filter_is_refused(filters: object) -> None:
    with pytest.raises(ValidationError):
        CanBridgeSettings.model_validate({"a_to_b": filters})
