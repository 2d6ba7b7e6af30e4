"""Catadioptric cameras from their geometry: a viewer, and mirrors before it."""
