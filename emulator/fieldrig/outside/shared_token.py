"""The secret that a rig, its processes and its tools share where others could reach them.

It is the text of the environment variable FIELDRIG_TOKEN, or else the content of the file that FIELDRIG_TOKEN_FILE
names.  The rig that listens makes that file at its first start, with a random token that only its user can read, so
that the containers of a rig can share a volume without a secret to configure.

The token itself is never transmitted.  Zenoh proves it by its own handshake (`endpoint`), and a process that attaches
to a hub by `proof`, the answer to a challenge that differs for each connection.
"""

import hashlib
import hmac
import os
import secrets
import tempfile
from pathlib import Path
from typing import Final

from fieldrig.errors import ConfigError, Mistake, RigError

TOKEN_VARIABLE: Final = "FIELDRIG_TOKEN"
FILE_VARIABLE: Final = "FIELDRIG_TOKEN_FILE"
LONGEST: Final = 4096
"""Longest token, in characters."""
_MADE_BYTES: Final = 32
_REMEDY: Final = f"set {TOKEN_VARIABLE} to a secret that the rig and its tools share, or don't set it"


def token() -> str | None:
    """Return the token; None if none is set, or its file is not there yet.

    ConfigError if it is blank or cannot be read.
    """
    text = os.environ.get(TOKEN_VARIABLE)
    if text is not None:
        return _checked(text, TOKEN_VARIABLE)
    name = os.environ.get(FILE_VARIABLE)
    if name is None:
        return None
    if not name:
        raise _wrong(FILE_VARIABLE, "is empty, expected the path of a file", "name a file, or don't set the variable")
    try:
        with Path(name).open("rb") as file:
            content = file.read(LONGEST + 1)
        return _checked(content.decode(), name)
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as cause:
        raise _wrong(name, f"the token cannot be read: {cause}", f"see {FILE_VARIABLE}") from cause


def make_token() -> None:
    """Make the token's file if one is named and missing.

    If several processes do so at once, all get the same token.
    """
    name = os.environ.get(FILE_VARIABLE)
    if not name or os.environ.get(TOKEN_VARIABLE) is not None or Path(name).exists():
        return
    path = Path(name)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, aside = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")  # mode 0600
        try:
            with os.fdopen(handle, "w", encoding="ascii", newline="\n") as file:
                file.write(secrets.token_urlsafe(_MADE_BYTES) + "\n")
                file.flush()
                os.fsync(file.fileno())
            os.link(aside, path)
        except FileExistsError:  # another one was first
            pass
        finally:
            os.unlink(aside)  # noqa: PTH108  mkstemp gives a text
    except OSError as cause:
        raise RigError(
            f"no token can be made at {path}: {cause.strerror}",
            f"let {FILE_VARIABLE} name a file in a folder that this user can write to, or set {TOKEN_VARIABLE}",
        ) from cause


def proof(token: str, nonce: str, bus: str, member: str) -> str:
    """Return the proof that `member` knows the token, for one connection to the hub of `bus`."""
    return hmac.new(token.encode(), "\0".join((nonce, bus, member)).encode(), hashlib.sha256).hexdigest()


def is_proof(given: str, token: str, nonce: str, bus: str, member: str) -> bool:
    return hmac.compare_digest(given.encode(), proof(token, nonce, bus, member).encode())


def _checked(text: str, source: str) -> str:
    token_ = text.strip()
    if not token_:
        raise _wrong(source, "the token is empty", _REMEDY)
    if len(token_) > LONGEST or not token_.isprintable():
        raise _wrong(source, f"expected a token of at most {LONGEST} printable characters", _REMEDY)
    return token_


def _wrong(source: str, what: str, remedy: str) -> ConfigError:
    return ConfigError([Mistake(source, None, "", what, remedy)])
