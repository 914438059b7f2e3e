"""`fieldrig draw --rig`: the picture of a rig file as SVG."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

from fieldrig.errors import ConfigError, UsageError
from fieldrig_page.draw_command import draw

CONFIGS = Path(__file__).parents[2] / "configs"
SVG = "{http://www.w3.org/2000/svg}"


def drawn(tmp_path: Path, name: str, columns: int | None = None) -> ElementTree.Element:
    target = tmp_path / "rig.svg"
    draw(CONFIGS / name, target, is_rig=True, columns=columns)
    return ElementTree.parse(target).getroot()


def texts(picture: ElementTree.Element) -> list[str]:
    return [str(text.text) for text in picture.iter(f"{SVG}text")]


def cards(picture: ElementTree.Element) -> list[tuple[float, ...]]:
    rects = [rect for rect in picture.iter(f"{SVG}rect") if rect.get("class") == "card"]
    return [tuple(float(rect.get(key, "")) for key in ("x", "y", "width", "height")) for rect in rects]


def test_the_lab_has_four_cards_with_their_kinds_and_cables(tmp_path: Path) -> None:
    picture = drawn(tmp_path, "lab.yaml")
    assert len(cards(picture)) == 4
    assert {"tank", "io", "sensor", "drive", "plant.tank", "canopen.node", "can0", "mb_tcp"} <= set(texts(picture))
    assert len({y for _, y, _, _ in cards(picture)}) == 1


@pytest.mark.long
def test_cards_lie_inside_the_picture_and_beside_each_other(tmp_path: Path) -> None:
    picture = drawn(tmp_path, "ring.yaml", columns=3)
    width, height = float(picture.get("width", "")), float(picture.get("height", ""))
    places = cards(picture)
    assert all(x > 0 and x + w < width and y > 0 and y + h < height for x, y, w, h in places)
    for at, (x, y, w, h) in enumerate(places):
        for other_x, other_y, _, _ in places[at + 1 :]:
            assert abs(x - other_x) >= w or abs(y - other_y) >= h


@pytest.mark.long
def test_the_line_of_a_ring_joins_its_stations_in_order(tmp_path: Path) -> None:
    picture = drawn(tmp_path, "ring.yaml")
    lines = [path.get("d", "") for path in picture.iter(f"{SVG}path") if path.get("class") == "link f-ring"]
    stations = len([text for text in texts(picture) if text in ("max4", "mc4")]) - 1  # the name of max4 is its kind
    assert len(lines) == stations - 1 + 1  # between them, and the strip with the name of the ring


@pytest.mark.parametrize(
    ("target", "options", "words"),
    [
        ("rig.png", {"is_rig": True}, "expected a name that ends in .svg"),
        ("rig.svg", {"is_rig": True, "wires": ["tank.level"]}, "no wires and no time"),
        ("rig.svg", {"is_rig": True, "begin": "1s"}, "no wires and no time"),
        ("rig.svg", {"columns": 3}, "--columns is for the picture of a rig"),
    ],
)
def test_options_that_do_not_fit_are_refused(
    tmp_path: Path, target: str, options: dict[str, object], words: str
) -> None:
    with pytest.raises(UsageError, match=words):
        draw(CONFIGS / "lab.yaml", tmp_path / target, **options)  # type: ignore[arg-type]
    assert not (tmp_path / target).exists()


def test_a_rig_file_with_mistakes_is_refused(tmp_path: Path) -> None:
    (tmp_path / "wrong.yaml").write_text("time: virtual\ndevices: {tank: {kind: plant.tnk}}\n", encoding="utf-8")
    with pytest.raises(ConfigError):
        draw(tmp_path / "wrong.yaml", tmp_path / "rig.svg", is_rig=True)
