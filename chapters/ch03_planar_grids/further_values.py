"""The numbers that the page on 6.3.1 quotes."""


def name_values(open_results):
    """Name them."""
