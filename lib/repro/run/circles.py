"""Cycles of a graph: nodes that reach each other, after all that they reach."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import TypeVar

Node = TypeVar("Node", bound=Hashable)


def circles(start: Node, targets: Callable[[Node], Iterable[Node]]) -> Iterator[set]:
    """Return the strongly connected components reachable from ``start``, in reverse
    order.

    Tarjan's algorithm without recursion, because call chains have any length.
    """
    met: dict[Node, int] = {start: 0}
    lowest = {start: 0}
    path = [start]
    open_ = {start}
    todo = [(start, iter(targets(start)))]
    while todo:
        node, further = todo[-1]
        target = next((t for t in further if t not in met or t in open_), None)
        if target is None:
            todo.pop()
            if todo:
                before = todo[-1][0]
                lowest[before] = min(lowest[before], lowest[node])
            if lowest[node] == met[node]:
                at = path.index(node)
                circle = set(path[at:])
                del path[at:]
                open_ -= circle
                yield circle
        elif target in met:
            lowest[node] = min(lowest[node], met[target])
        else:
            met[target] = lowest[target] = len(met)
            path.append(target)
            open_.add(target)
            todo.append((target, iter(targets(target))))
