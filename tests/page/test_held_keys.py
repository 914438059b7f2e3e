"""Held keys against a model: whatever pages do, and however slow the device is, a key is down while a page holds it."""

import asyncio
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given
from hypothesis import strategies as st
from in_loop import in_loop

from fieldrig.control.messages import NoAnswerError
from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig_page.held_keys import HeldKey, HeldKeys

KEYS = [HeldKey("panel", f"key.{name}", False) for name in ("F1", "F2")]
PAGES = ["one", "other"]


class Panel:
    """A device that takes its time, by turns of the loop, and may refuse or not answer at first."""

    def __init__(self, turns: list[int]) -> None:
        self.down: set[str] = set()
        self.troubles: list[ControlError] = []
        self._turns = turns

    async def write(self, _device: str, point: str, value: Value) -> None:
        for _ in range(self._turns.pop() if self._turns else 0):
            await asyncio.sleep(0)
        if self.troubles:
            raise self.troubles.pop()
        (self.down.add if value else self.down.discard)(point)


acts = st.tuples(
    st.sampled_from(["press", "release", "drop", "wait"]),
    st.sampled_from(KEYS),
    st.sampled_from(PAGES),
    st.integers(0, 4),
)


@given(st.lists(acts, max_size=25), st.lists(st.integers(0, 5), max_size=25))
def test_a_key_is_down_while_a_page_holds_it(steps: list[tuple[str, HeldKey, str, int]], turns: list[int]) -> None:
    with TemporaryDirectory() as folder:
        asyncio.run(play(steps, turns, Path(folder) / "held.json"))


async def play(steps: list[tuple[str, HeldKey, str, int]], turns: list[int], file: Path) -> None:
    panel = Panel(list(turns))
    held = HeldKeys(panel.write, file)
    model: dict[HeldKey, set[str]] = {key: set() for key in KEYS}
    running: list[asyncio.Future[None]] = []
    for what, key, page, times in steps:
        if what == "press":
            running.append(asyncio.ensure_future(held.press(key, page, True)))
            model[key].add(page)
        elif what == "release":
            running.append(asyncio.ensure_future(held.release(key, page)))
            model[key].discard(page)
        elif what == "drop":
            held.drop(page)
            for holders in model.values():
                holders.discard(page)
        for _ in range(times if what == "wait" else 1):  # each begins before the next
            await asyncio.sleep(0)
    await asyncio.gather(*running)
    await held.settled()
    assert held.held == {key for key, holders in model.items() if holders}
    assert panel.down == {key.point for key in held.held}


@in_loop
async def test_a_press_that_is_refused_holds_nothing(tmp_path: Path) -> None:
    panel = Panel([])
    held = HeldKeys(panel.write, tmp_path / "held.json")
    panel.troubles = [ControlError("the panel is switched off")]
    with pytest.raises(ControlError, match="switched off"):
        await held.press(KEYS[0], "one", True)
    assert held.held == set()


@in_loop
async def test_a_release_that_gets_no_answer_is_sent_again(tmp_path: Path) -> None:
    panel = Panel([])
    held = HeldKeys(panel.write, tmp_path / "held.json", again_s=0)
    await held.press(KEYS[0], "one", True)
    panel.troubles = [NoAnswerError("panel does not answer"), NoAnswerError("panel does not answer")]
    held.drop("one")
    await held.settled()
    assert panel.down == set()


@in_loop
async def test_a_page_that_was_killed_releases_its_keys_also_without_a_run_folder_before(tmp_path: Path) -> None:
    panel, file = Panel([]), tmp_path / "run" / "rig" / "held.json"
    await HeldKeys(panel.write, file).press(KEYS[0], "one", True)
    assert panel.down == {KEYS[0].point}
    await HeldKeys(panel.write, file).release_left()
    assert panel.down == set()


@in_loop
async def test_a_disk_that_is_full_takes_no_key_away(tmp_path: Path) -> None:
    panel = Panel([])
    (tmp_path / "full").touch()
    held = HeldKeys(panel.write, tmp_path / "full" / "held.json")
    await held.press(KEYS[0], "one", True)
    await held.release(KEYS[0], "one")
    assert panel.down == set()


@pytest.mark.parametrize(
    "text", [b"", b"{}", b'[["panel"]]', b'[["panel", 5, false]]', b"[[[], {}, []]]", b"\xff", b"[" * 999]
)
@in_loop
async def test_a_damaged_file_releases_nothing(tmp_path: Path, text: bytes) -> None:
    panel = Panel([])
    (tmp_path / "held.json").write_bytes(text)
    await HeldKeys(panel.write, tmp_path / "held.json").release_left()
