import pytest
from canopen_bench import CanopenBench


@pytest.fixture
def bench() -> CanopenBench:
    """The I/O module as node 5 after boot-up, whose message has been read."""
    bench = CanopenBench()
    assert bench.take() == ["705#00"]
    return bench


@pytest.fixture
def running(bench: CanopenBench) -> CanopenBench:
    """The I/O module in 'operational', after its initial PDOs have been read."""
    bench.send("000#01 05")
    return bench
