"""Chapter 5: calibration of flexible mirror imaging systems."""
