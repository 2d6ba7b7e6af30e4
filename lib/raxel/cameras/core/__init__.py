"""Common parts of all cameras: their maps, files, and rays in bulk."""
