"""The SERCOS ring (IEC 61491)."""
