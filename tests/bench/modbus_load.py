"""The load of modbus_load.c in Python, for where there is no compiler: slower than the servers that it measures."""

import selectors
import socket
import sys
import time

from report import percentile

REQUEST = bytes.fromhex("000100000006 01 03 0000 000A")
ANSWER_SIZE = 29


def main(port: int, clients: int, seconds: float) -> None:
    selector = selectors.DefaultSelector()
    asked: dict[socket.socket, int] = {}
    for _ in range(clients):
        client = socket.create_connection(("127.0.0.1", port))
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        selector.register(client, selectors.EVENT_READ, client)
        client.sendall(REQUEST)
        asked[client] = time.monotonic_ns()
    round_trips_us = []
    begin_ns = time.monotonic_ns()
    while (now_ns := time.monotonic_ns()) < begin_ns + seconds * 1e9:
        for key, _ in selector.select(2.0):
            asker: socket.socket = key.data
            answer = asker.recv(512)
            assert len(answer) == ANSWER_SIZE, answer.hex(" ")
            now_ns = time.monotonic_ns()
            round_trips_us.append((now_ns - asked[asker]) / 1e3)
            asked[asker] = now_ns
            asker.sendall(REQUEST)
    per_s = len(round_trips_us) / (now_ns - begin_ns) * 1e9
    print(
        f"{len(round_trips_us)} {per_s:.0f} {percentile(round_trips_us, 50):.0f} {percentile(round_trips_us, 99):.0f}"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))
