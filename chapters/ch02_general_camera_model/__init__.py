"""Chapter 2: the general camera model and generic calibration.

A parametric camera model describes one class of lenses. The general camera model stores
a ray for every pixel and describes any camera, but thousands of rays must be
calibrated. The thesis reviews parametric models (2.2), defines the general model (2.3)
and derives Sturm and Ramalingam's calibration from three planar grids in unknown poses
(2.4). Section 2.5 compares it with Zhang's parametric method, on simulated data and on
fisheye images.

We found several misprints in the equations; corrected, they hold. The generic method is
better at strong distortion, as claimed, but whether and where the methods cross depends
on how the text is interpreted. The generic residual is not constant in our fisheye
images: homographies between chessboard corners bias it. A small residual does not imply
accurate rays.

Read 2.3, 2.4.1 and 2.5.1 first. For an ordinary or fisheye lens, also compare a
parametric fisheye model.
"""
