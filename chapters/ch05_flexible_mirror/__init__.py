"""Chapter 5: calibration of flexible mirror imaging systems.

A camera that looks into a flexible mirror can change its field of view, but each bend
changes the ray of every pixel. The thesis calibrates the flat mirror once with a
monitor. After each deflection it updates the shape from two images of one chessboard
(the SPFC2 method, 5.2). It reports accurate deflections and hardly any accumulation of
errors.

Here the method runs on simulated set-ups at three error levels, since the thesis states
neither its set-up nor its noise. Deflections are recovered. Ray errors grow over
successive updates. The thesis's back-projection check does not show this and residuals
show a part, because a fitted board pose absorbs ray errors. The linear estimate is too
small for a geometric reason, the nearness of the board.

Read 5.2, 5.3.3a (calibration and error levels) and 5.3.3b (three deflections) first.
"""
