"""Whether stated errors are the errors that happen: what a page shows as a record.

Each module of this package is a part. It has

- `WHAT`: one line, what is drawn or photographed and what is counted;
- `TITLES`: heads of its own columns, by their names in rows;
- `measured()`: yields rows, dictionaries with a `case` of its own (text) and numbers,
  texts or None under names that all rows of the part share.

Names in COMMON mean the same in all parts: `count`, errors that were looked at, or
sets, where a part heads it so;
`within1` to `within3`, per cent of them within so many stated standard deviations;
`ratio`, a robust standard deviation of errors over stated ones; `left_out`, per cent of
what could have been answered and was not; `told`, what the user is told, in its words.
Seeds are fixed in the module, and nothing was settled by looking at them.
"""

COMMON = {
    "case": "Case",
    "count": "Errors",
    "within1": "Within 1 SD (%)",
    "within2": "2 SD (%)",
    "within3": "3 SD (%)",
    "ratio": "Error over stated",
    "left_out": "Left out (%)",
    "told": "Told",
}
