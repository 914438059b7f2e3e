"""Programs of IEC 61131-3: from the text of an engineer to generated Python that a controller runs in slices."""
