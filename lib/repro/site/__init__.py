"""The site: pages assembled, built and checked."""
