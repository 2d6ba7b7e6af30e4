"""The site: pages put together, built and checked."""
