"""The guard of the page: tokens for looking and for operating, and the names and origins that are accepted.

A token comes in the address that `fieldrig up` prints, and becomes a cookie; scripts send it as `Authorization:
Bearer`.  Each request is compared with where the page listens:

    421  `Host` is not ours: another site has let its name lead to this machine (DNS rebinding)
    403  `Origin` is another site, or is missing beside a cookie where a browser sends it; or the role may only look
    401  there is no token, or a wrong one

This is plain ASGI, as Starlette's own middleware for requests never sees a socket.
"""

import hmac
import ipaddress
import json
from collections.abc import Collection, Mapping, Sequence
from typing import Final
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from fieldrig.errors import RigError
from fieldrig.outside.addresses import is_loopback
from fieldrig_page.live import Role

POLICY: Final = (
    "default-src 'none'; script-src 'self' {scripts}; style-src 'self'; img-src 'self' data: blob:; connect-src 'self';"
    " font-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS: Final = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",  # the first address has the token in it
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-cache",  # a file is asked for each time, and sent only if it is another one
}
SAFE: Final = frozenset({"GET", "HEAD"})
LONGEST_BODY: Final = 1 << 18
"""Longest body of a request in bytes."""


class DeniedError(RigError):
    """A request that is refused, with its HTTP status."""

    def __init__(self, status: int, what: str, remedy: str = "") -> None:
        super().__init__(what, remedy)
        self.status = status


class Hosts:
    """The names under which browsers reach the page: those of `Host`, with the port."""

    def __init__(self, listen: tuple[str, int], more: Collection[str] = ()) -> None:
        """`listen` is host and port where the page listens, `more` are further names as `host:port`."""
        host, self._port = listen
        self._is_local = is_loopback(host)
        self._more = frozenset(name.lower() for name in more)

    def __contains__(self, host: str) -> bool:
        """Return whether a browser may call us so.

        Beyond loopback every address of the port is ours, as a site that another name leads to has a name, and
        addresses cannot be made to lead elsewhere.
        """
        if host.lower() in self._more:
            return True
        try:
            parts = urlsplit(f"//{host}")
            name, port = parts.hostname or "", parts.port if parts.port is not None else 80
        except ValueError:
            return False
        if port != self._port or parts.username is not None or parts.path or parts.query or parts.fragment:
            return False
        return is_loopback(name) or (not self._is_local and _is_address(name))


class Guard:
    def __init__(
        self, app: ASGIApp, hosts: Hosts, port: int, tokens: Mapping[Role, str], scripts: Sequence[str]
    ) -> None:
        """`scripts` are the hashes of the scripts inside of the page, as a content security policy has them."""
        self._app, self._hosts, self._tokens = app, hosts, tokens
        self._cookie = f"fieldrig-{port}"  # cookies don't know ports, and two rigs of a host must not share one
        policy = POLICY.format(scripts=" ".join(f"'{script}'" for script in scripts))
        every = {**HEADERS, "content-security-policy": policy}
        self._headers = [(name.encode(), value.encode()) for name, value in every.items()]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            return  # the server's own start and end, of which there are none
        send = self._with_headers(send) if scope["type"] == "http" else send
        try:
            self._check_names(scope)
            if (entry := self._entry(scope)) is not None:
                await entry(scope, receive, send)
                return
            scope["role"] = self._role_of(scope)
            if scope["role"] == "look" and scope["type"] == "http" and scope["method"] not in SAFE:
                remedy = "open the other address that `fieldrig up` has printed, the one to operate"
                raise DeniedError(403, "this address is for looking only", remedy)
        except DeniedError as refusal:
            await _refuse(scope, receive, send, refusal)
            return
        await self._app(scope, receive, send)

    def _check_names(self, scope: Scope) -> None:
        headers = Headers(scope=scope)
        host, origin = headers.get("host", ""), headers.get("origin")
        if len(headers.getlist("host")) != 1 or host not in self._hosts:
            raise DeniedError(421, "this page has another name", "open the address that `fieldrig up` has printed")
        # A browser that another site makes use of sends our cookie; a script sends the token itself, or nothing.
        is_browser = _bearer(headers) is None and self._cookie in HTTPConnection(scope).cookies
        needs_origin = is_browser and (scope["type"] == "websocket" or scope["method"] not in SAFE)
        if origin is None and not needs_origin:
            return
        if origin is None or origin.lower() not in (f"http://{host}".lower(), f"https://{host}".lower()):
            remedy = "send the header Origin with this page's address, or Authorization: Bearer TOKEN"
            raise DeniedError(403, "another site asks", remedy)

    def _entry(self, scope: Scope) -> Response | None:
        """Return the answer to the address with a token: it becomes a cookie, and leaves the address."""
        if scope["type"] != "http" or scope["path"] != "/" or scope["method"] not in SAFE:
            return None
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", ())
        if len(given) != 1 or self._role(given[0]) is None:
            return None
        answer = RedirectResponse("/", 303)
        # Not SameSite=Strict: a link to the page on another one would be answered with 401.
        answer.set_cookie(self._cookie, given[0], httponly=True, samesite="lax", path="/")
        return answer

    def _role_of(self, scope: Scope) -> Role:
        connection = HTTPConnection(scope)
        given = _bearer(connection.headers)
        role = self._role(given if given is not None else connection.cookies.get(self._cookie, ""))
        if role is None:
            raise DeniedError(401, "the token is missing or wrong", "open the address that `fieldrig up` has printed")
        return role

    def _role(self, given: str) -> Role | None:
        found: Role | None = None
        for role, token in self._tokens.items():  # compared with all, so that the time tells nothing
            if hmac.compare_digest(given.encode(), token.encode()):
                found = role
        return found

    def _with_headers(self, send: Send) -> Send:
        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                message = {**message, "headers": [*message["headers"], *self._headers]}
            await send(message)

        return with_headers


def refusal_json(refusal: RigError) -> bytes:
    """Return a refusal as the body of its answer."""
    return json.dumps({"what": refusal.what, "remedy": refusal.remedy}, ensure_ascii=False).encode()


async def _refuse(scope: Scope, receive: Receive, send: Send, refusal: DeniedError) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close"})  # before it is accepted: HTTP status 403
        return
    if scope["path"].startswith("/api/"):
        answer = Response(refusal_json(refusal), refusal.status, media_type="application/json")
    else:
        answer = Response(f"{refusal.what}: {refusal.remedy}\n", refusal.status, media_type="text/plain")
    await answer(scope, receive, send)


def _bearer(headers: Headers) -> str | None:
    scheme, _, token = headers.get("authorization", "").partition(" ")
    return token.strip() if scheme.lower() == "bearer" else None


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
