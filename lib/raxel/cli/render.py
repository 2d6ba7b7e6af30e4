"""`raxel render RIG --out SET --seed N`"""

from raxel.cli.terminal import on_one_line
from raxel.lab.render_set import render_set
from raxel.lab.rig import load_rig


def render(options, say):
    """Photograph the rig's target in the virtual laboratory."""
    rig = load_rig(options.rig)
    image_set = render_set(rig, options.out, options.seed, say)
    files = sum(len(view.files) for view in image_set.views)
    print(
        f"{image_set.name}: {len(image_set.views)} views, {files} images of "
        f"{image_set.width} x {image_set.height} px, in {on_one_line(image_set.folder)}"
    )
