"""SERCOS: the protocol between a master and its drives on a fibre ring (IEC 61491)."""
