"""Shapes fitted to points: planes, circles, conics and cylinders.

Each fit begins with an algebraic one and ends with the least squared orthogonal
distances and the covariance of the parameters. Each has a robust counterpart.
"""
