"""Photographs: real lenses calibrated from real photographs.

One page per image set: the photographs that the workflow brings, and what you add with
`make report RECORDED=path/to/set`.
"""
