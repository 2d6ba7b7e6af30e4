from .exchange import Export as Export
from .exchange import export_camera as export_camera
from .exchange import import_camera as import_camera
