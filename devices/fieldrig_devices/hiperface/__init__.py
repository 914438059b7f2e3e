"""The SM motor's SinCos encoder with its memory, the electronic name plate in it, and who reads both: HIPERFACE."""
