"""General linear cameras: orthographic, pushbroom, crossed slits."""
