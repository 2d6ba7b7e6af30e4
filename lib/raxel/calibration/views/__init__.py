"""Views of planar targets: the point that each pixel sees."""
