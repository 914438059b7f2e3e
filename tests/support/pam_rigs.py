"""Rigs with a PAM in virtual time: its ring, its wires, and an application that a test writes."""

from pathlib import Path

from fieldrig.pytest_plugin import RigMaker
from fieldrig.virtual.rig import Rig

PAM = "{kind: pam, application: app.pam, links: {ring: ring, wires: wires}}"
RIG = """
time: virtual
speed: max
buses:
  ring: {{kind: pamring.virtual}}
  wires: {{kind: wires.virtual}}
devices:
  pam: {pam}
"""


def pam_rig(make: RigMaker, folder: Path, application: str, further: str = "", pam: str = PAM) -> Rig:
    """Return the rig of a PAM; `further` has the lines of other devices, `pam` the value of the PAM's own."""
    (folder / "app.pam").write_text(application)
    (folder / "rig.yaml").write_text(RIG.format(pam=pam) + further)
    return make(folder / "rig.yaml")
