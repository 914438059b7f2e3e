"""python canopen's LocalNode as a process: `local_node.py EDS NODE_ID key=value...` of `can.Bus`, until stdin ends."""

import sys
from typing import Any

import canopen


def main(eds: str, node_id: str, *pairs: str) -> None:
    bus: dict[str, Any] = dict(pair.split("=", 1) for pair in pairs)
    network = canopen.Network()
    network.connect(**bus)
    network.add_node(canopen.LocalNode(int(node_id), eds))
    print("ready", flush=True)  # noqa: T201  for the process that waits for it
    sys.stdin.read()
    network.disconnect()


if __name__ == "__main__":
    main(*sys.argv[1:])
