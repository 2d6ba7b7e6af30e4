"""Reading and writing: documents, archives of arrays, result files; this machine."""
