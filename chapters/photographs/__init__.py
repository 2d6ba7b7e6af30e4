"""Photographs: real lenses calibrated from real photographs.

One page per image set: the sets that the workflow downloads, and those added with
`make report RECORDED=path/to/set`.
"""
