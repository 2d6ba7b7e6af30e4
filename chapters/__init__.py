"""The chapters: a package per chapter of the thesis, a page per section."""
