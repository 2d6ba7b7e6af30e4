"""Lenses: parametric cameras without mirrors."""
