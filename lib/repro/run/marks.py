"""Experiments, and the producers that read their results.

A chapter marks its functions with the decorators of this module. The arguments are
literals, or names of literals at the top of a module: the workflow finds producers by
parsing the chapter (`repro.run.discover`) and never imports a chapter for the plan.
Arguments do not change the key of a result.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

import numpy as np

from repro.run.outcomes import Plan

ROOT_SEED = 2009
Producer = TypeVar("Producer", bound=Callable)


def _mark(
    kind: str, identifier: str, **details: object
) -> Callable[[Producer], Producer]:
    def mark(function: Producer) -> Producer:
        marks = getattr(function, "repro_marks", ())
        function.repro_marks = (*marks, {"kind": kind, "id": identifier, **details})
        return function

    return mark


def experiment(
    identifier: str,
    *,
    artefact: str,
    inputs: Sequence[str] = (),
    needs: Sequence[str] = (),
    rendered: Mapping[str, Sequence[str]] | None = None,
) -> Callable[[Producer], Producer]:
    """Mark ``function(effort) -> Plan`` as an experiment.

    With ``needs`` an experiment reads others, as ``function(effort, results)``: for
    trials that draw measurement errors from those found in rendered images.
    ``rendered`` declares the image sets that it opens by
    `repro.run.rendered.rendered_set`, as {"quick": ("RIG/SEED", ...), "full": (...)};
    a separate task renders each, and their rigs are inputs. ``inputs`` lists other rigs
    that it reads. The workflow divides a long experiment into parts; the result does
    not depend on them.
    """
    return _mark(
        "experiment",
        identifier,
        artefact=artefact,
        inputs=inputs,
        needs=needs,
        rendered=rendered or {},
    )


def experiments(
    artefacts: Mapping[str, str],
    *,
    inputs: Sequence[str] = (),
    needs: Sequence[str] = (),
    rendered: Mapping[str, Sequence[str]] | None = None,
) -> Callable[[Producer], Producer]:
    """Mark ``function(effort, identifier) -> Plan`` as a family of experiments.

    ``artefacts`` maps the id of each to its artefact; the rest is as for `experiment`
    and the same for all, with ``results`` as a third argument if there are ``needs``.
    """

    def mark(function: Producer) -> Producer:
        for identifier, artefact in artefacts.items():
            one = experiment(
                identifier,
                artefact=artefact,
                inputs=inputs,
                needs=needs,
                rendered=rendered,
            )
            function = one(function)
        return function

    return mark


def figure(
    identifier: str,
    *,
    needs: Sequence[str] = (),
    evidence: str,
    scene: bool = False,
    published: Sequence[str] = (),
) -> Callable[[Producer], Producer]:
    """Mark ``function(results) -> Drawing`` as the producer of a figure.

    With ``scene`` the drawing has a `raxel.show.Scene` or a `Film`, to which the page
    links. With ``published``, ids of numbers of the ledger, it is called as
    ``function(results, published)``, with {id: printed value}. Printed values are for
    drawing only: all results exist by then, and no experiment, claim or number can read
    them.
    """
    return _mark(
        "figure",
        identifier,
        needs=needs,
        evidence=evidence,
        scene=scene,
        published=published,
    )


def figures(
    identifiers: Sequence[str] | Mapping[str, Sequence[str]],
    *,
    needs: Sequence[str] = (),
    evidence: str,
    scene: bool = False,
    published: Sequence[str] = (),
) -> Callable[[Producer], Producer]:
    """Mark ``function(results, identifier) -> Drawing`` as a family of figures.

    ``identifiers`` are their ids, or ids with the ``needs`` of each if they differ. The
    rest is as for `figure` and the same for all, with the printed numbers as a third
    argument if any are ``published``.
    """

    def mark(function: Producer) -> Producer:
        for identifier, own in _with_needs(identifiers, needs):
            one = figure(
                identifier,
                needs=own,
                evidence=evidence,
                scene=scene,
                published=published,
            )
            function = one(function)
        return function

    return mark


def _with_needs(
    identifiers: Sequence[str] | Mapping[str, Sequence[str]], needs: Sequence[str]
) -> list[tuple[str, Sequence[str]]]:
    """Ids of a family with the needs of each: its own, or those of all."""
    if isinstance(identifiers, Mapping):
        return list(identifiers.items())
    return [(identifier, needs) for identifier in identifiers]


def table(
    identifier: str,
    *,
    needs: Sequence[str] = (),
    evidence: str,
    published: Sequence[str] = (),
) -> Callable[[Producer], Producer]:
    """Mark ``function(results) -> Table`` as the producer of a table.

    ``published`` is as for a `figure`.
    """
    return _mark(
        "table", identifier, needs=needs, evidence=evidence, published=published
    )


def claim(
    identifier: str,
    *,
    needs: Sequence[str] = (),
    evidence: str,
    readings: Sequence[str] = (),
) -> Callable[[Producer], Producer]:
    """Mark ``function(results) -> Reading`` as the test of a claim.

    ``readings`` are the questions of the ledger that concern it. With any, it is called
    as ``function(results, options)``, once for each combination of their options
    (`repro.judge.readings`), ``options`` being {question: option}.
    """
    return _mark("claim", identifier, needs=needs, evidence=evidence, readings=readings)


def numbers(
    identifier: str, *, needs: Sequence[str] = (), evidence: str
) -> Callable[[Producer], Producer]:
    """Mark ``function(results) -> {number id: Value}`` for an artefact's numbers."""
    return _mark("numbers", identifier, needs=needs, evidence=evidence)


def seed_of(artefact: str, condition: dict, trial: int) -> list[int]:
    """Return the entropy of one trial, from (artefact, condition, trial) only."""
    text = json.dumps([ROOT_SEED, artefact, condition, trial], sort_keys=True)
    digest = hashlib.sha256(text.encode()).digest()
    return np.frombuffer(digest, dtype="<u4").tolist()


def trial_rng(artefact: str, condition: dict, trial: int) -> np.random.Generator:
    """Return the generator of one trial, independent of core, shard and order."""
    return np.random.default_rng(
        np.random.SeedSequence(seed_of(artefact, condition, trial))
    )


def shard_pairs(plan: Plan, shard: int, of: int) -> list[tuple[int, int]]:
    """Return consecutive (condition index, trial) pairs for one shard.

    Few jobs then repeat the work that the trials of a condition share.
    """
    pairs = plan.pairs
    return pairs[len(pairs) * shard // of : len(pairs) * (shard + 1) // of]


def run_trials(
    artefact: str, plan: Plan, pairs: Sequence[tuple[int, int]]
) -> tuple[list[dict], dict[str, np.ndarray]]:
    """Run the pairs; return one record per trial, and their arrays by name."""
    records, arrays = [], {}
    for index, trial in pairs:
        condition = plan.conditions[index]
        values = plan.trial(dict(condition), trial_rng(artefact, condition, trial))
        scalars = {}
        for name, value in _flatten(values):
            if isinstance(value, np.ndarray):
                arrays[f"{index}/{trial}/{name}"] = value
            else:
                scalars[name] = _plain(name, value)
        records.append({"condition": index, "trial": trial, "values": scalars})
    return records, arrays


def _flatten(values: dict, prefix: str = "") -> list[tuple[str, object]]:
    flat = []
    for key, value in values.items():
        if isinstance(value, dict):
            flat += _flatten(value, f"{prefix}{key}.")
        else:
            flat.append((prefix + key, value))
    return flat


def _plain(name: str, value: object) -> float | int | str | bool | None:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"trial value {name!r} is a {type(value).__name__}")
