"""Cameras without a formula: tables of rays, and smooth fields over an image."""
