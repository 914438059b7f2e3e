"""A hundred modems at one exchange: fifty laptops call fifty controllers at once."""

import pytest
from dialled_rig import Laptop, call, open_rig, run_until


@pytest.mark.long
def test_fifty_calls_at_once_bring_fifty_pages() -> None:
    with open_rig(baud=38_400, pairs=50, axes=1) as rig:
        laptops = [Laptop(rig, pair) for pair in range(50)]
        call(rig, laptops)
        pages = [laptop.fetch("/AXES.HTM") for laptop in laptops]
        run_until(rig, laptops, lambda: all(page.is_complete for page in pages))
        assert {bytes(page.content[:17]) for page in pages} == {b"HTTP/1.1 200 OK\r\n"}
        assert all(rig.get(f"max4_{pair}", "Com1UserState") == 7 for pair in range(50))
