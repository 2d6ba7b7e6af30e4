"""Smooth rays: a lens formula, and a smooth field of what it leaves."""
