"""`make readme`: the figures of README.md, reduced from those of the full report.

They are part of the repository, because README.md is read without a build.
"""

from PIL import Image

SIZE_PX = (560, 360)
N_COLOURS = 48


def main() -> None:
    """Write report/readme; the figures are built already."""
    for name in ("ext_zoo_room", "fig_3_4", "fig_2_3"):
        with Image.open(f"figures/full/{name}.png") as image:
            small = image.convert("RGB")
        small.thumbnail(SIZE_PX, Image.Resampling.LANCZOS)
        small = small.quantize(N_COLOURS, dither=Image.Dither.NONE)
        small.save(f"report/readme/{name}.png", optimize=True)


if __name__ == "__main__":
    main()
