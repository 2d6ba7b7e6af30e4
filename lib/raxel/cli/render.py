"""`raxel render RIG --out SET --seed N --noise LEVEL`"""

from raxel.cli.terminal import on_one_line
from raxel.errors import InputError
from raxel.lab.mirror_set_rig import (
    is_mirror_set_rig,
    load_mirror_set_rig,
    render_mirror_set,
)
from raxel.lab.rig import load_rig
from raxel.lab.set_rendering import render_set


def render(options, say):
    """Photograph the rig's target, or a whole mirror set, in the virtual laboratory."""
    if is_mirror_set_rig(options.rig):
        _render_mirror_set(options, say)
        return
    if options.noise:
        raise InputError(
            f"--noise: found with {options.rig}, whose pictures have one level; leave "
            "it out"
        )
    rig = load_rig(options.rig)
    image_set = render_set(rig, options.out, options.seed, say)
    print(f"{image_set.name}: {_told(image_set)}, in {on_one_line(image_set.folder)}")


def _render_mirror_set(options, say):
    rig = load_mirror_set_rig(options.rig)
    made = render_mirror_set(rig, options.out, options.seed, options.noise, say)
    for field, image_set in made.image_sets.items():
        print(f"{made.name}: {field}: {_told(image_set)}")
    print(f"{made.name}: {len(made.steps) + 1} stages, in {on_one_line(made.folder)}")


def _told(image_set):
    files = sum(len(view.files) for view in image_set.views)
    return (
        f"{len(image_set.views)} views, {files} images of "
        f"{image_set.width} x {image_set.height} px"
    )
