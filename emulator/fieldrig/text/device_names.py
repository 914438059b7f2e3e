"""Names for the devices of a rig, made from the names of files."""

import re
from pathlib import Path


def name_for(file: Path) -> str:
    """Return a name for the device, made from that of the EDS file so that it is valid in a rig file."""
    name = re.sub(r"[^a-z0-9_-]+", "-", file.stem.lower()).strip("-_")
    return name if re.match(r"[a-z]", name) and name != "can0" else f"node-{name}".rstrip("-")
