"""Shapes fitted to points: planes, circles, conics and cylinders.

Each fit begins with an algebraic one and ends with the least squared orthogonal
distances and the covariance of what it found. Each has a twin that bears wrong points.
"""
