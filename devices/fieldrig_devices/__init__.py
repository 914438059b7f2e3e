"""The devices, and the plants behind them."""
