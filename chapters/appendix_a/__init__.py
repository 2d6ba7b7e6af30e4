"""Appendix A: decoding location from active grids.

An active grid is phase-shift structured light on a monitor. Each pixel decodes the
screen position that it sees from the phase of a sinusoid, shown in four steps. Monitors
and cameras are not linear, so the recorded profile is not an exact sinusoid. The
appendix of the thesis shows that part of this distortion cancels.

The page here completes the proof. It gives the orders that cancel for any number
of steps, the error of the others, and a correction of the last formula of the
thesis. Section 3.2.2 describes the patterns and the decoder. Read it first.
"""
