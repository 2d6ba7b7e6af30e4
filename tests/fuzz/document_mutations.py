"""Damage to what a document says: types, keys, numbers, depth, aliases."""

import copy
import json

import yaml

NUMBERS = [0, -1, 1, 2, 3, 15, 40, 1000, 10**4, 10**6, 10**9, 2**31, 2**63, 10**400]
NUMBERS += [1e-300, 5e-324, 1e-9, 0.5, 1e9, 1e19, 1e100, 1e300, -1e300, -0.0]
NUMBERS += [float("nan"), float("inf"), float("-inf")]
TEXTS = [
    "",
    "x",
    "view0.png",
    "../view0.png",
    "/",
    ".",
    "chessboard",
    "gray",
    "y" * 10**5,
]
TEXTS += [
    "a\nb",
    "\x1b[31m",
    "\u202e",
    "ä",
    "null",
    "1e5",
    "{x}",
    "%s",
    "<svg>",
    "\x00",
]
SCALARS = [None, True, False, *NUMBERS, *TEXTS]
# Lines that YAML reads in ways of its own.
YAML_LINES = (
    "a: &a [x, x, x, x, x, x, x, x, x]\nb: &b [*a, *a, *a, *a, *a, *a, *a, *a, *a]\n"
    "c: &c [*b, *b, *b, *b, *b, *b, *b, *b]\nd: &d [*c, *c, *c, *c, *c, *c, *c, *c]\n"
    "e: &e [*d, *d, *d, *d, *d, *d, *d, *d]\nf: [*e, *e, *e, *e, *e, *e, *e, *e]\n",
    "a: &a [*a]\n",
    "name: twice\nname: twice\n",
    "a: !!python/object:os.system x\n",
    "? [a]\n: b\n",
    "<<: {a: 1}\n",
    "a: !!bool x\n",
    "a: ._\n",
    "= : 1\n",
    "--- x\n",
    "%TAG ! x\n",
    "\t- x\n",
    "a: 0x\n",
    "a: 2026-01-31\n",
    "a: 1:60:60\n",
    'a: "\\ud800"\n',
    "a: " + "9" * 5000 + "\n",
    "a: " + "[" * 2000 + "\n",
)


def mutated_document(rng, data):
    """Plain data with one to three things in it changed; often only numbers."""
    data = copy.deepcopy(data)
    if rng.random() < 0.4:
        return _with_other_numbers(rng, data)
    for _ in range(rng.integers(1, 4)):
        places = [path for path in _paths(data) if path]
        if not places:
            return data
        path = places[rng.integers(len(places))]
        parent, key = _at(data, path[:-1]), path[-1]
        HOW[rng.integers(len(HOW))](rng, parent, key, data)
    return data


def mutated_yaml(rng, data, others):
    """A YAML text of the changed data; some have a strange line too."""
    data = mutated_document(rng, data)
    try:
        text = yaml.safe_dump(data, allow_unicode=True)
    except RecursionError:
        # JSON is YAML too, and its writer goes deeper.
        text = json.dumps(data)
    if rng.random() < 0.15:
        lines = text.splitlines(keepends=True)
        at = int(rng.integers(len(lines) + 1))
        strange = YAML_LINES[rng.integers(len(YAML_LINES))]
        text = "".join([*lines[:at], strange, *lines[at:]])
    return text.encode("utf-8", "surrogatepass")


def mutated_json(rng, data, others):
    """A JSON text of the changed data."""
    return json.dumps(mutated_document(rng, data)).encode()


def scalar(rng):
    """A number, text, truth value or null, mostly an extreme one."""
    return SCALARS[rng.integers(len(SCALARS))]


def _with_other_numbers(rng, data):
    """One to three numbers scaled, a little or by much, negated or made extreme."""
    numbers = [path for path in _paths(data) if _is_number(_at(data, path))]
    for _ in range(rng.integers(1, 4)):
        path = numbers[rng.integers(len(numbers))]
        parent, old = _at(data, path[:-1]), _at(data, path)
        new = old * 10 ** rng.normal(0, rng.choice([0.1, 1, 4]))
        if rng.random() < 0.1:
            new = -new
        if rng.random() < 0.1:
            new = float(NUMBERS[rng.integers(13)])
        parent[path[-1]] = round(new) if isinstance(old, int) else float(new)
    return data


def _is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _replaced(rng, parent, key, data):
    parent[key] = scalar(rng)


def _extreme(rng, parent, key, data):
    """A number, the first below the place, made an extreme one."""
    for path in _paths(parent[key]):
        found = _at(parent[key], path)
        if _is_number(found):
            holder = _at(parent[key], path[:-1]) if path else parent
            holder[path[-1] if path else key] = NUMBERS[rng.integers(len(NUMBERS))]
            return
    parent[key] = NUMBERS[rng.integers(len(NUMBERS))]


def _taken_away(rng, parent, key, data):
    del parent[key]


def _doubled(rng, parent, key, data):
    if isinstance(parent, list):
        parent.append(copy.deepcopy(parent[key]))
    else:
        parent[f"{key}s"] = copy.deepcopy(parent[key])


def _swapped(rng, parent, key, data):
    """What stands here put where something else stands."""
    places = [path for path in _paths(data) if path]
    path = places[rng.integers(len(places))]
    _at(data, path[:-1])[path[-1]] = copy.deepcopy(parent[key])


def _wrapped(rng, parent, key, data):
    """Put into lists or mappings, a few or very many."""
    for _ in range(int(rng.choice([1, 2, 30, 90, 200]))):
        parent[key] = [parent[key]] if rng.random() < 0.5 else {"a": parent[key]}


def _repeated(rng, parent, key, data):
    """A list of the same thing, up to some thousand times."""
    many = int(rng.choice([0, 1, 2, 100, 5000]))
    size = len(json.dumps(parent[key])) + 1
    parent[key] = [parent[key]] * min(many, 200_000 // size)


HOW = (
    *(_replaced, _replaced, _extreme, _extreme, _extreme),
    *(_taken_away, _doubled, _swapped, _wrapped, _repeated),
)


def _paths(data, path=()):
    yield path
    if isinstance(data, dict):
        for key in data:
            yield from _paths(data[key], (*path, key))
    elif isinstance(data, list):
        for index, part in enumerate(data[:50]):
            yield from _paths(part, (*path, index))


def _at(data, path):
    for key in path:
        data = data[key]
    return data
