"""Chessboard (checkerboard) detection without clicks and without a lens model."""
