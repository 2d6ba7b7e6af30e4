"""The framework of the reproduction: experiments, ledger, verdicts, figures, pages."""
