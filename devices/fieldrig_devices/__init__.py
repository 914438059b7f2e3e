"""What answers: devices and the plants behind them."""
