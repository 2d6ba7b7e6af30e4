"""Appendix A: decoding location from active grids."""
