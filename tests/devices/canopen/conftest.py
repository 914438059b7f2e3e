import pytest
from canopen_bench import CanopenBench


@pytest.fixture
def bench() -> CanopenBench:
    """The I/O module as node 5, booted; its boot-up message is taken."""
    bench = CanopenBench()
    assert bench.take() == ["705#00"]
    return bench


@pytest.fixture
def running(bench: CanopenBench) -> CanopenBench:
    """In operational, with the PDOs taken that it sends at the start."""
    bench.send("000#01 05")
    return bench
