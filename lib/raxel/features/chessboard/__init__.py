"""Chessboards found without clicks, whatever the lens: corners, order and size."""
