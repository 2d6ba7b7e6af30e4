"""The chapters: one package per chapter of the thesis, one page per section."""
