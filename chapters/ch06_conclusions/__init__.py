"""Chapter 6: conclusions and future work.

The thesis ends with a summary of its contributions (6.1), its publications (6.2) and
directions for further work (6.3). It makes two claims of its own here; both summarise
results of chapters 3 and 4 and are judged on the pages there.

Page 6.1 compares the five goals of the thesis, its contributions and its summaries with
the verdicts of this report. Page 6.3 lists each direction for further work, with what
this report tried and what came out. All verdicts on both pages are computed from the
results of the build.
"""
