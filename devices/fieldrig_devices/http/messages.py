"""Requests and responses of HTTP, without their way over a connection."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import Final
from urllib.parse import parse_qs, unquote, urlsplit

_ABSOLUTE: Final = re.compile(rb"https?://([^/?#]*)", re.IGNORECASE)
MOST_FIELDS: Final = 256
"""Fields of a query; a request with more is wrong."""


@dataclass(frozen=True, slots=True)
class Request:
    """A request for a page."""

    path: str
    """The path with its percent-encoding resolved, such as `/INDEX.HTM`."""
    query: Mapping[str, list[str]] = field(default_factory=dict)
    """Values of the query by name, in their order."""

    @classmethod
    def of_target(cls, target: str) -> "Request":
        """Return the request for a target, in origin form or absolute form (RFC 9112, 3.2).

        ValueError for a target that is neither.
        """
        path, _, query = target.partition("?")
        if not path.startswith("/"):
            parts = urlsplit(path)
            if parts.scheme != "http" or not parts.netloc:
                raise ValueError(f"expected a path such as /INDEX.HTM, got {target!r}")
            path = parts.path or "/"
        return cls(unquote(path, errors="strict"), parse_qs(query, max_num_fields=MOST_FIELDS))


@dataclass(frozen=True, slots=True)
class Response:
    """A response with all of its content."""

    status: HTTPStatus
    content: bytes
    content_type: str = "text/html; charset=utf-8"


def authority_of(target: bytes) -> bytes | None:
    """Return host and port of a target in absolute form, which count instead of the field Host (RFC 9112, 3.2.2).

    None for a target in another form.
    """
    found = _ABSOLUTE.match(target)
    return found[1] if found is not None else None


Answer = Callable[[Request], Response]


VIEWPORT: Final = '<meta name="viewport" content="width=device-width, initial-scale=1">'


def refusal(status: HTTPStatus) -> Response:
    """Return a short page that gives the status."""
    title = f"{status.value} {status.phrase}"
    return Response(status, f"<!DOCTYPE html>{VIEWPORT}<title>{title}</title><h1>{title}</h1>\n".encode())
