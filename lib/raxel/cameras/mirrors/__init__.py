"""Catadioptric cameras from their geometry: a viewing camera and mirrors."""
