"""Send a job to the build's warm process (`forks`), or run it in a new process.

An interrupted build leaves a file next to the socket: no job starts after that.

    python -I -S lib/repro/workflow/ask.py LABEL MODULE ...

It runs once per job, so it imports only fast modules.
"""

import os
import socket
import sys


def main(words):
    """Return the exit status of the job, which writes to this process's streams."""
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
        print(
            "the job ended without a message (killed? out of memory?)", file=sys.stderr
        )
    return answer[0] if answer else 1


def connected(address):
    """A connection to the warm process, None without one."""
    connection = socket.socket(socket.AF_UNIX)
    try:
        connection.connect(address)
    except OSError:
        return None
    return connection


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
