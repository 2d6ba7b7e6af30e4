"""The ledger of the thesis, and the verdicts on it."""
