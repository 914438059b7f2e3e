"""The variables of function blocks that take one another by reference can be listed, and looked at."""

from pathlib import Path

from iec_program import IecBench

PROGRAM = (Path(__file__).parent / "programs" / "block-by-own-reference.st").read_text(encoding="ascii")


def test_the_values_of_a_block_that_refers_to_its_own_type_come_to_an_end() -> None:
    bench = IecBench(PROGRAM)
    bench.cycle()
    paths = {symbol.path for symbol in bench.runtime.symbols.values()}
    assert {"PLC_PRG.a.sum", "PLC_PRG.a.next.n", "PLC_PRG.l.other.n"} <= paths
    assert "PLC_PRG.a.next.next.n" not in paths
    assert bench.runtime.read(bench.runtime.find("PLC_PRG.a.next.next.n")) == 5
