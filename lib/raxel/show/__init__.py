"""Scenes in space, drawn by pyvista: images, and pages on which they turn.

Needs the extra `show` (`pip install raxel[show]`).
`rendering_missing` returns what images need and is missing.
Ready-made scenes: `camera_scene` here, `rigs.rig_scene` and `sets.set_scene`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
