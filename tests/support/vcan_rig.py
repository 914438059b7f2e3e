"""The I/O node on the kernel's CAN, for masters that are not ours."""

from canopen_bench import IO32
from conform_peers import NODE_ID

IO_ON_VCAN = f"""
time: real
start_timeout_s: 60
buses:
  can0: {{kind: can.socketcan, channel: vcan0}}
devices:
  io: {{kind: canopen.node, node_id: {NODE_ID}, eds: {IO32}, links: {{can: can0}}}}
"""
