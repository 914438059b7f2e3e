"""Model of the ASA-RT ARP two-axis card."""
