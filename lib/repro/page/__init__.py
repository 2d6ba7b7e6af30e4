"""What a page is made of: cells, figures, exercises, and their execution."""
