"""The pages of the controller: HTML files on the flash disk with live values, and values as JSON.

Source: PacDrive manual 5188-5217 (digest PD-281, PD-282).  The manual gives no names of pages.  `/` is
`\\INDEX.HTM`, and `/values?of=belt.Position&of=belt.Torque` gives values as JSON, null for an unknown path; with `tag=`
and the attributes of a tag it gives the HTML of that tag.  Only files
whose name has one of the endings in `TYPES` are pages, not those of the project, one of which contains the password.
"""

import json
from http import HTTPStatus
from math import isfinite
from pathlib import Path
from typing import Final

from fieldrig.device import Value
from fieldrig_devices.http.messages import Request, Response, refusal
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.pages.tags import expanded, shown_by, value_of
from fieldrig_devices.max4.storage.disk import FlashDisk, file_name

FIRST_PAGE: Final = "/INDEX.HTM"
VALUES: Final = "/values"
HTML: Final = "text/html; charset=utf-8"
TYPES: Final = {
    ".HTM": HTML,
    ".HTML": HTML,
    ".CSS": "text/css; charset=utf-8",
    ".JS": "text/javascript; charset=utf-8",
    ".TXT": "text/plain; charset=utf-8",
    ".LOG": "text/plain; charset=utf-8",
    ".PNG": "image/png",
    ".GIF": "image/gif",
    ".JPG": "image/jpeg",
    ".SVG": "image/svg+xml",
    ".ICO": "image/x-icon",
}


class Site:
    """The pages of one controller."""

    def __init__(self, controller: Controller, disk: FlashDisk) -> None:
        self._controller, self._disk = controller, disk

    def answer(self, request: Request) -> Response:
        if request.path == VALUES:
            return self._values(request.query.get("of", []), request.query.get("tag", []))
        path = FIRST_PAGE if request.path == "/" else request.path
        content_type = TYPES.get(path[path.rfind(".") :].upper())
        data = self._file(path)
        if content_type is None or data is None:
            return refusal(HTTPStatus.NOT_FOUND)
        if content_type == HTML:
            data = expanded(data.decode("utf-8", "replace"), self._controller).encode()
        return Response(HTTPStatus.OK, data, content_type)

    def _file(self, path: str) -> bytes | None:
        try:
            return self._disk.read(file_name("\\" + path[1:]))
        except ValueError:
            return None

    def _values(self, paths: list[str], tags: list[str]) -> Response:
        values = {path: _finite(value_of(self._controller, path)) for path in paths}
        values |= {tag: shown_by(tag, self._controller) for tag in tags}
        text = json.dumps(values, ensure_ascii=False, allow_nan=False)
        return Response(HTTPStatus.OK, text.encode("utf-8", "replace"), "application/json")


def _finite(value: Value | None) -> Value | None:
    """The value as JSON can have it, which knows no infinity."""
    return None if isinstance(value, float) and not isfinite(value) else value


def default_pages() -> dict[str, bytes]:
    """Return the pages that are installed with a project, by their names on the flash disk."""
    return {f"\\{path.name}": path.read_bytes() for path in sorted((Path(__file__).parent / "files").iterdir())}
