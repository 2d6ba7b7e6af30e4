"""Pages that decide together: claims of one page may judge an artefact of another."""

from __future__ import annotations

from collections.abc import Sequence

from repro.judge.ledger import Ledger
from repro.run.discover import Producer


def judged_with(made: Sequence[Producer], page: str, book: Ledger) -> list[str]:
    """Return the page, and the pages whose claims decide the verdict of its
    artefacts."""
    drawn = [p.id for p in made if p.page == page and p.kind in ("figure", "table")]
    deciding = {claim for name in drawn for claim in book.claims_of(name)}
    pages = {p.page for p in made if p.kind == "claim" and p.id in deciding}
    return [page, *sorted(pages - {page})]
