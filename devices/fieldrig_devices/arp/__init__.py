"""The ASA-RT ARP two-axis card."""
