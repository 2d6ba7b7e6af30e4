"""Book-keeping of the reproduction: experiments, ledger, verdicts, figures, pages."""
