"""Hand a job to the build's warm process (`forks`), or start one for it.

A build that was interrupted leaves a file beside the socket: nothing starts any more.

    python -I -S lib/repro/workflow/ask.py LABEL MODULE ...

It runs once a job: it imports nothing that takes time to import.
"""

import os
import socket
import sys


def main(words):
    """Exit status of the job; the job writes to this process's streams."""
    address = os.environ.get("RAXEL_JOBS", "")
    connection = connected(address)
    if connection is None and os.path.exists(f"{address}.ended"):
        return 1
    if connection is None:
        os.execv(sys.executable, [sys.executable, "-m", "repro.workflow.job", *words])
    variables = [f"{name}={value}" for name, value in os.environ.items()]
    parts = [os.getcwd(), str(len(words)), *words, *variables]
    asked = b"\0".join(os.fsencode(part) for part in parts)
    try:
        socket.send_fds(connection, [len(asked).to_bytes(8, "big")], [1, 2])
        connection.sendall(asked)
        answer = connection.recv(1)
    except ConnectionError:
        answer = b""
    if not answer:
        print("the job ended without a word (killed? out of memory?)", file=sys.stderr)
    return answer[0] if answer else 1


def connected(address):
    """A connection to the warm process, None where there is none."""
    connection = socket.socket(socket.AF_UNIX)
    try:
        connection.connect(address)
    except OSError:
        return None
    return connection


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
