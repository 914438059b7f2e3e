"""The peer of the hub's unpaced SDO: python canopen's LocalNode and client, two processes, over udp_multicast.

    sdo_peer.py EDS SECONDS          serves node 5, runs the client, prints round trips a second

python-can joins the group on the default network card, so this runs in a network namespace of its own only.
"""

import subprocess
import sys
import time

import canopen


def network() -> canopen.Network:
    joined = canopen.Network()
    joined.connect(interface="udp_multicast", channel="239.74.163.2")
    return joined


def serve(eds: str, seconds: str) -> None:
    joined = network()
    joined.create_node(5, eds)
    subprocess.run([sys.executable, __file__, eds, seconds, "client"], check=True)
    joined.disconnect()


def ask(eds: str, seconds: str) -> None:
    joined = network()
    sdo = joined.add_node(5, eds).sdo
    sdo.upload(0x1000, 0)
    until_s, count = time.monotonic() + float(seconds), 0
    while time.monotonic() < until_s:
        sdo.upload(0x1000, 0)
        count += 1
    print(count / float(seconds))
    joined.disconnect()


if __name__ == "__main__":
    (ask if len(sys.argv) > 3 else serve)(*sys.argv[1:3])
