"""V1 to V1000 of an ARP card survive SIGKILL: nothing that left the card is forgotten."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from arp_bench import CardBench

from fieldrig.storage.store import FileStore

pytestmark = pytest.mark.system

TOLD = 300
CHILD = """
import sys
from pathlib import Path
from arp_bench import CardBench
from fieldrig.storage.store import FileStore
from fieldrig.testing import RecordedLink

class Wires(RecordedLink):
    def send(self, signal):
        if signal.name == "card1.O101" and signal.value:
            print(bench.access.V[1], bench.access.V[900], flush=True)

program = "V2 == 900\\nLOOP:\\nV1 += 1\\nV[V2] == V1\\nO101 == !O101\\nGOTO LOOP"
bench = CardBench(program, store=FileStore(Path(sys.argv[1])), wires=Wires())
while True:
    bench.run_for(1)
"""


@pytest.mark.manual("ARP-061")
def test_variables_survive_a_kill(tmp_path: Path) -> None:
    path = tmp_path / "card1"
    support = str(Path(__file__).parents[1] / "support")
    told = (0, 0)
    with subprocess.Popen(
        [sys.executable, "-c", CHILD, str(path)], stdout=subprocess.PIPE, text=True, env={"PYTHONPATH": support}
    ) as child:
        assert child.stdout is not None
        for _ in range(TOLD):
            first, last = child.stdout.readline().split()
            told = (int(first), int(last))
        child.send_signal(signal.SIGKILL)
    assert child.returncode == -signal.SIGKILL
    bench = CardBench(store=FileStore(path))
    assert told > (0, 0)
    assert bench.access.V[1] >= told[0]
    assert bench.access.V[900] >= told[1]
    assert bench.warning == 0  # the memory is what it was
