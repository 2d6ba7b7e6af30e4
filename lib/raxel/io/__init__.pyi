from .files import read_json as read_json
