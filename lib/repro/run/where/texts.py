"""Which texts an expression can be: the names that loops and f-strings make.

A text is a tuple of parts, `ANY` where a part is not known before the program runs.
"""

from __future__ import annotations

import ast
import re
from functools import cache
from itertools import product

from repro.run.where.meanings import Meanings, Part
from repro.run.where.scopes import DictEntry, Scope, Term

ANY = None
Text = tuple[str | None, ...]
UNKNOWN: Text = (ANY,)
MAX_TEXTS = 5000
# Methods of texts whose value is the same whenever it is asked for.
PURE = {
    name: getattr(str, name)
    for name in (
        "replace", "lower", "upper", "title", "capitalize", "strip", "removeprefix",
        "removesuffix", "split", "rsplit", "partition", "rpartition",
    )
}  # fmt: skip


class Reader(Meanings):
    """What texts the expressions of a page's scopes can be."""

    def texts(self, part: Part) -> list[Text]:
        """Every text that an expression can be; `UNKNOWN` where it can be any."""
        return list(dict.fromkeys(text for text, _ in self.placed(part)))

    def placed(self, part: Part) -> list[tuple[Text, DictEntry | None]]:
        """Texts, each with the entry of a dict whose key it is."""
        found: list[tuple[Text, DictEntry | None]] = []
        for one in self.resolved(part):
            entry = getattr(one, "entry", None) or getattr(part, "entry", None)
            if isinstance(one, Term):
                with self._once("texts", one) as first:
                    texts = self._texts(one) if first else [UNKNOWN]
                found += [(text, entry) for text in texts]
            else:
                found.append((UNKNOWN, entry))
        return found or [(UNKNOWN, getattr(part, "entry", None))]

    def _texts(self, term: Term) -> list[Text]:
        node, scope = term.node, term.scope
        if isinstance(node, ast.Constant):
            return [(str(node.value),)]
        if isinstance(node, ast.JoinedStr):
            return self._joined([self._texts(Term(n, scope)) for n in node.values])
        if isinstance(node, ast.FormattedValue):
            texts = self.texts(Term(node.value, scope))
            return texts if node.format_spec is None else self._formatted(node, scope)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            sides = (Term(side, scope) for side in (node.left, node.right))
            return self._joined([self.texts(side) for side in sides])
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
            whole = self._computed(node.value, scope)
            return [(w[node.slice.value],) if w else UNKNOWN for w in whole]
        if isinstance(node, ast.Call):
            return [(w,) if isinstance(w, str) else UNKNOWN
                    for w in self._computed(node, scope)]  # fmt: skip
        return [UNKNOWN]

    def _formatted(self, node: ast.FormattedValue, scope: Scope) -> list[Text]:
        specs = self._texts(Term(node.format_spec, scope))
        values = [r.node for r in self.resolved(Term(node.value, scope))]
        if not values or any(not isinstance(v, ast.Constant) for v in values):
            return [UNKNOWN]
        if any(ANY in spec for spec in specs):
            return [UNKNOWN]
        try:
            return [(format(v.value, "".join(s)),) for v in values for s in specs]
        except ValueError:  # of another kind than the format asks for
            return [UNKNOWN]

    def _computed(self, node: ast.expr, scope: Scope) -> list:
        """What a method of a text gives; None where the text is not known."""
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            return [None]
        method, given = PURE.get(node.func.attr), [
            a.value for a in node.args if isinstance(a, ast.Constant)
        ]  # fmt: skip
        if method is None or len(given) < len(node.args):
            return [None]
        texts = self.texts(Term(node.func.value, scope))
        return [
            None if ANY in text else method("".join(text), *given) for text in texts
        ]

    @staticmethod
    def _joined(parts: list[list[Text]]) -> list[Text]:
        count = 1
        for texts in parts:
            count *= len(texts)
        if count > MAX_TEXTS:
            parts = [texts if len(texts) == 1 else [UNKNOWN] for texts in parts]
        return list(dict.fromkeys(merged(sum(turn, ())) for turn in product(*parts)))


def merged(text: Text) -> Text:
    """A text with fixed parts that stand beside each other put together."""
    found: list[str | None] = []
    for part in text:
        if part and found and found[-1] is not ANY:
            found[-1] += part
        elif part != "" and not (part is ANY and found and found[-1] is ANY):
            found.append(part)
    return tuple(found)


def fits(text: Text, name: str) -> bool:
    """Whether a text can be that name."""
    return _pattern(text).fullmatch(name) is not None


@cache
def _pattern(text: Text) -> re.Pattern[str]:
    return re.compile(
        "".join(".+" if part is ANY else re.escape(part) for part in text)
    )


def fixed_length(text: Text) -> int:
    """Characters of a text that are known: the more, the more it says."""
    return sum(len(part) for part in text if part is not ANY)
