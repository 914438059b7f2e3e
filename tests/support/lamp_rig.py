"""The rig of a lamp and its switch, as rig files for tests of processes and commands."""

from pathlib import Path

KINDS = Path(__file__).parents[1] / "system" / "lamp_kinds.py"


def lamp_rig(switch: str = "", time: str = "time: real", wires: str = "wires.hub") -> str:
    """Return the text of the file; `switch` has further keys of the switch, each with a comma behind it."""
    return f"""
{time}
buses:
  wires: {{kind: {wires}}}
devices:
  lamp: {{kind: "lamp_kinds:Lamp", links: {{wires: wires}}}}
  switch: {{kind: "lamp_kinds:Switch", lamp: lamp, {switch}links: {{wires: wires}}}}
"""
