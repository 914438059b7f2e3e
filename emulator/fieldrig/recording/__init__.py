"""Recording of signals: sampled where they are made, published in batches, and read without gaps."""
