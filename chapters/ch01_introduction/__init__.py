"""Chapter 1: introduction.

The thesis calibrates non-conventional cameras: cameras whose optical path is changed
on purpose, for example by a fisheye lens or a mirror. Such a camera can show the whole
horizon in one image. The usual pinhole model does not describe it, so it needs another
calibration. The thesis studies wide-angle and omnidirectional cameras (chapters 2 to
4) and flexible mirror cameras (chapter 5).

One statement of this chapter can be tested: the resolution of an unwrapped
panorama varies from top to bottom. Page 1.1.2 tests it, and shows the simulated
cameras from which all rendered images of this report come. A reader in a hurry can
start with chapter 2.
"""
