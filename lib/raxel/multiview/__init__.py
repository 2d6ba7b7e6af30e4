"""What a calibrated camera is for."""
