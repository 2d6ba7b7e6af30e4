"""Chapter 2: the general camera model and generic calibration."""
