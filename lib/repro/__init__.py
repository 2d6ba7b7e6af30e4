"""Book-keeping of the reproduction: experiments, ledger, verdicts, figures and pages."""
