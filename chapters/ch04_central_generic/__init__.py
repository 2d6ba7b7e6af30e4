"""Chapter 4: efficient generic calibration of central cameras.

Generic calibration gives every pixel a ray of its own. Its standard linear stage is
sensitive to noise and ignores that all rays of a central camera meet in one point.
The thesis proposes CGSP (Central Generic Synthetic Pinhole calibration): one grid
serves as the image plane of a synthetic pinhole camera. Pinhole methods then find the
centre (4.1) and the poses of further grids (4.2). Section 4.3 compares CGSP with the
standard method and reports about ten times smaller errors on a mirror camera.

The construction is exact. CGSP is more accurate than the printed standard method in
our simulations too, but the reason is numerical. A well-conditioned standard method
is as accurate, and the factor of ten does not reappear in 4.3.

Read 4.1.1, 4.1.5 and 4.3.2a first.
"""
