"""One CiA 402 drive alone on CAN, with its motor and load."""
