"""Experiments, what they leave, and the workflow that runs them."""
