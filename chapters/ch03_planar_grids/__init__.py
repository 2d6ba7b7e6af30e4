"""Chapter 3: planar grids, their corners and their patterns.

Every calibration in this thesis starts from points on a flat target. The chessboard
detectors of 2009 often fail in mirrors and fisheyes, where rows of corners are curved.
The chapter offers two remedies. CELECT (3.1) follows the curved edges from four clicks,
and localisers refine the corners. Active grids (3.2), phase-shift structured light on a
monitor, need no corners: each pixel decodes the screen position that it sees. Section
3.3 tests both, on synthetic and rendered images.

Here a current detector finds more boards than CELECT, whose limits are small squares
and blur. Interpolation between corners has a bias that grows with the square of their
pitch. Active grids avoid it and tolerate most disturbances, but not all noise.

Read 3.1.2, 3.2.1 and 3.2.2 first. In practice: fine squares and a current detector for
an ordinary or fisheye lens, an active grid for a camera with discontinuities.
"""
