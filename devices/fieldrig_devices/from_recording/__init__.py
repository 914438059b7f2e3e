"""`fieldrig new --from`: a rig with one device for each that a recording shows."""
