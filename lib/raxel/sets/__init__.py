"""Image sets: a folder of photographs and a set.yaml that says what they show."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
