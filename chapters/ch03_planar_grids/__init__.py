"""Chapter 3: planar grids, their corners and their patterns."""
