"""Exchange formats in XML: PLCopen TC6 and part 10 of IEC 61131, with the habits of the tools that write them."""
