"""The fibre ring: SERCOS telegrams between one master and its drives (IEC 61491)."""
