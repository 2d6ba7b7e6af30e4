"""What holds for cameras of every kind: their maps, files, and rays in bulk."""
