"""Lenses: cameras with a formula for where a direction is seen."""
