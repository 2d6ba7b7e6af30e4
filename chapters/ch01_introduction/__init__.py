"""Chapter 1: introduction."""
