"""A page of the MAx-4 in a browser, over the telephone line of configs/teleservice.yaml, as docs/pictures has it.

`python -m tests.pictures.browser` needs chromium.  The rig, the call and the browser are in a network of their own if
the user may make one.  No test compares the picture, as fonts differ between machines.
"""

import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from dialled import dialled
from network_namespace import network_namespace, why_not
from running_rig import AskedRig, until
from tests.pictures.album import FOLDER

from fieldrig.testing import free_port

RIG: Final = Path(__file__).parents[2] / "configs" / "teleservice.yaml"
OFFLINE: Final = 6  # Com1UserState
LOGIN: Final = ("--user", "service", "--password", "pacdrive")
SIZE: Final = "920,640"
LIMIT_S: Final = 60
# It shall show one page, and speak to no other host.
QUIET: Final = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars"),
)


def main() -> None:
    with nullcontext() if why_not() else network_namespace(), AskedRig(RIG, None) as rig:
        rig.until_ready()
        until(lambda: rig.get("max4/Com1UserState") == OFFLINE)
        port = free_port()
        with dialled(str(rig.folder / "run/teleservice/modem"), *LOGIN, "--forward", f"{port}:80") as dial:
            dial.until("Ctrl-C hangs up.")
            take(f"http://127.0.0.1:{port}/", FOLDER / "teleservice-page.png")


def take(address: str, picture: Path) -> None:
    with TemporaryDirectory() as profile:
        command = ["chromium", *QUIET, f"--user-data-dir={profile}", f"--window-size={SIZE}", "--timeout=20000"]
        subprocess.run(
            [*command, f"--screenshot={picture}", address], check=True, timeout=LIMIT_S, stderr=subprocess.DEVNULL
        )


if __name__ == "__main__":
    main()
