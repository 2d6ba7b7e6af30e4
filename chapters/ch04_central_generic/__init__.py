"""Chapter 4: efficient generic calibration of central cameras."""
