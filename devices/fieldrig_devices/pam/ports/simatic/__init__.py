"""The Simatic S5 DualPort: variables at addresses of a shared memory, with FIFOs of addresses (chapter 14)."""
