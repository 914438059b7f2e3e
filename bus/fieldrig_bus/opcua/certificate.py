"""The server's own certificate: made at its first start, and kept in the run folder, so that clients can trust it."""

from pathlib import Path

from asyncua.crypto.cert_gen import setup_self_signed_certificate
from cryptography.x509.oid import ExtendedKeyUsageOID


async def make_certificate(folder: Path, application: str, host: str) -> tuple[Path, Path]:
    """Return the paths of certificate and private key, which only this user can read.  They are made if missing."""
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    certificate, key = folder / "certificate.der", folder / "key.pem"
    key.touch(mode=0o600) if not key.exists() else None
    if key.stat().st_size == 0:
        key.unlink()
    await setup_self_signed_certificate(
        key,
        certificate,
        application,
        host,
        [ExtendedKeyUsageOID.CLIENT_AUTH, ExtendedKeyUsageOID.SERVER_AUTH],
        {"organizationName": "fieldrig", "commonName": application.rpartition(":")[2]},
    )
    key.chmod(0o600)
    return certificate, key
