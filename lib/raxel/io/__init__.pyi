from .files import read_json as read_json
from .rendering import RenderingError as RenderingError
from .rendering import rendering_missing as rendering_missing
