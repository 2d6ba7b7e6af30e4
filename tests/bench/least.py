"""The least processor time of several runs."""

import time


def least_ms(work, repeats):
    """Milliseconds of work() at its best: what else the machine does can only add."""
    work()
    taken = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        taken.append(time.process_time() - start)
    return 1000 * min(taken)
