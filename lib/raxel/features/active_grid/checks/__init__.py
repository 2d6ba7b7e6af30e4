"""Consistency checks on the images of an active grid, in addition to decoding."""
