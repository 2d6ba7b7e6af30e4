"""Adjustment of centre and poses, and of the rays with them."""
