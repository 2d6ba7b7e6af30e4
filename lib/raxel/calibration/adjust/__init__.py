"""Bundle adjustment of centre and poses, with or without the rays."""
