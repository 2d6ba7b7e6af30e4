"""Export of cameras: exact through the code of the readers, and refits."""

import numpy as np
import pytest

from raxel.cameras import CAMERAS as KINDS
from raxel.cameras import (
    AxialCamera,
    MovingPupilCamera,
    OrthographicCamera,
    load_camera,
)
from raxel.cli import main
from raxel.errors import InputError
from raxel.formats import export_camera, import_camera
from raxel.formats.conventions import FORMATS
from raxel.formats.exchange import import_with_residual
from tests.camera_zoo import ZOO
from tests.format_cameras import CAMERAS, CELLS, EXACT
from tests.format_readers import READERS, exported
from tests.format_table import TABLE

# Readers in environments of their own: make test-formats.
ELSEWHERE = "opencv-omnidir", "mrcal"
FIRST_PIXEL = {"colmap": 0.5, "nerfstudio": 0.5}
NOT_READ = "basalt", "nerfstudio"


@pytest.mark.parametrize(("form", "name"), CELLS)
def test_exact_export_has_the_rays_of_the_camera(form, name, tmp_path):
    camera = CAMERAS[name]
    made, path, pixels, directions = exported(form, camera, tmp_path)
    assert (made.model, made.exact) == (EXACT[form][name], True)
    if form not in ELSEWHERE:
        found = READERS[form](path, directions) - FIRST_PIXEL.get(form, 0.0)
        # World to camera of OCamCalib is a polynomial fitted to the exact inverse.
        assert np.abs(found - pixels).max() < (1e-3 if form == "ocamcalib" else 1e-6)
    if form not in NOT_READ:
        again = import_camera(path, form)
        np.testing.assert_allclose(
            again.rays(pixels).directions, camera.rays(pixels).directions, atol=1e-9
        )


@pytest.mark.parametrize(
    ("form", "name", "largest"),
    [
        ("colmap", "kannala-brandt, decentred", 0.5),
        ("ros", "brown", 2),
        ("opencv", "tardif", 0.2),
        ("ocamcalib", "kannala-brandt 9", 1),
    ],
)
def test_refit_has_the_stated_residual(form, name, largest, tmp_path):
    """Also through the reader; skew and tangential terms need a refit."""
    made, path, pixels, directions = exported(form, ZOO[name], tmp_path)
    assert not made.exact
    rms, most = made.residuals["in the whole image"]
    assert rms < most < largest
    if form not in ELSEWHERE:
        found = READERS[form](path, directions) - FIRST_PIXEL.get(form, 0.0)
        off = np.hypot(*(found - pixels).T)
        assert off.max() < 1.5 * most
        assert np.sqrt(np.mean(off**2)) == pytest.approx(rms, rel=0.3)
        # The import, refitted where no camera has these terms, states its residual.
        axes = FORMATS[form].R_format_camera
        camera, (rms, _) = import_with_residual(path, form)
        off = np.hypot(*(camera.project(directions @ axes).pixels - found).T)
        assert rms < 0.2
        assert np.sqrt(np.mean(off**2)) < 2 * rms + 0.01 * largest


def test_residuals_are_stated_under_the_boards_and_beyond(tmp_path):
    """Boards in the middle of the image: the fit follows them."""
    camera = ZOO["kannala-brandt, decentred"]
    whole = exported("opencv-fisheye", camera, tmp_path)[0].residuals
    cells = np.zeros((48, 64), bool)
    cells[12:36, 12:52] = True
    try:
        camera.board_cells = cells
        camera.save(tmp_path / "camera.npz")
    finally:
        camera.board_cells = None
    camera = load_camera(tmp_path / "camera.npz")
    np.testing.assert_array_equal(camera.board_cells, cells)
    made = export_camera(camera, tmp_path / "camera.yml", "opencv-fisheye", True)
    under, beyond = (made.residuals[name] for name in ("under the boards", "beyond"))
    assert under[0] < whole["in the whole image"][0] < beyond[0]
    for line in made.lines():
        assert line in (tmp_path / "camera.yml").read_text()


def test_moving_pupil_is_exported_for_far_points(tmp_path):
    camera = MovingPupilCamera(CAMERAS["kannala-brandt"], [2.0])
    made, path, pixels, directions = exported("basalt", camera, tmp_path)
    assert (made.model, made.exact) == ("kb4", True)
    assert np.abs(READERS["basalt"](path, directions) - pixels).max() < 1e-6
    theta = np.radians(np.linspace(0, made.angle_deg, 100))
    arms = 2 * theta**2 * np.sin(theta)
    assert made.pupil_mm == pytest.approx(arms.max(), rel=0.01)
    assert "for far points" in path.read_text()


def test_maps_and_table_hold_the_rays(tmp_path):
    camera = AxialCamera("equisolid", 300, (320, 240), [3.0], 640, 480)
    export_camera(camera, tmp_path / "table.npz", "table")
    table, pixels = np.load(tmp_path / "table.npz"), [[600.0, 17.0], [320.0, 240.0]]
    for name in ("origins", "directions"):
        rays = getattr(camera.rays(pixels), name)
        np.testing.assert_array_equal(table[name][[17, 240], [600, 320]], rays)
    camera = ZOO["kannala-brandt, decentred"]
    export_camera(camera, tmp_path / "maps.npz", "maps")
    maps = np.load(tmp_path / "maps.npz")
    u, v = maps["mapx"][200, 300], maps["mapy"][200, 300]
    ray = maps["K"] @ maps["R_camera_view"].T @ camera.rays([[u, v]]).directions[0]
    np.testing.assert_allclose(ray[:2] / ray[2], [300, 200], atol=1e-3)
    assert maps["mapx"].dtype == np.float32


def test_program_exports_and_imports(tmp_path, capsys):
    path, out = tmp_path / "camera.npz", tmp_path / "camchain.yaml"
    CAMERAS["mei-rives"].save(path)
    options = ["--format", "kalibr", "--out"]
    assert main(["export", str(path), *options, str(out)]) == 0
    assert capsys.readouterr().out.startswith(f"{out}: omni-radtan, exact\n")
    assert main(["export", str(path), *options, str(out)]) == 2
    assert "exists; give --force to replace it" in capsys.readouterr().err
    assert main(["import", str(out), *options, str(tmp_path / "again.npz")]) == 0
    again = load_camera(tmp_path / "again.npz").rays([[40.0, 400.0]])
    expected = CAMERAS["mei-rives"].rays([[40.0, 400.0]])
    np.testing.assert_allclose(again.directions, expected.directions, atol=1e-9)


@pytest.mark.parametrize(
    ("camera", "form", "reason"),
    [
        (ZOO["brown, folding"], "basalt", "residual"),
        (
            OrthographicCamera(8, (320, 240), 640, 480),
            "opencv",
            "do not meet in one point",
        ),
    ],
)
def test_export_is_rejected_with_a_reason(camera, form, reason, tmp_path, capsys):
    path = tmp_path / "camera.npz"
    camera.save(path)
    options = ["--format", form, "--out", str(tmp_path / "out.yml")]
    assert main(["export", str(path), *options]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"raxel: {path}: ")
    assert reason in line
    assert not (tmp_path / "out.yml").exists()


KALIBR = """cam0:
  camera_model: {model}
  intrinsics: [{fu}, 280.0, 330.0, 250.0]
  distortion_model: radtan
  distortion_coeffs: [0.1, 0.0, 0.0, 0.0]
"""
ROS = """
image_width: 640
image_height: 480
distortion_model: plumb_bob
distortion_coefficients: {data: [0, 0, 0, 0, 0]}
camera_matrix: {rows: 3, cols: 3, data: [300, 0, 330, 0, 280, 250, 0, 0]}
"""
OCAM = "#\n5 -150 0 1e-3 0 0\n#\n2 1 1\n#\n250 330\n#\n1 0 0\n#\n480 640\n"
FAULTS = {
    ("kalibr", KALIBR.format(model="pinhole", fu=300.0)): "resolution: missing",
    (
        "kalibr",
        KALIBR.format(model="fisheye", fu=300.0) + "  resolution: [640, 480]\n",
    ): "model: found 'fisheye-radtan'",
    (
        "kalibr",
        KALIBR.format(model="pinhole", fu=".nan") + "  resolution: [640, 480]\n",
    ): "to float: '.nan'",
    ("colmap", "1 OPENCV 640 480 300 280 330 250 0 0 0 0\n" * 2): "2 cameras",
    ("colmap", "1 OPENCV 640 480 300 280 330 250 0 0 0\n"): "found 7; OPENCV has fx fy",
    ("colmap", "1 OPENCV 640 480 300 nan 330 250 0 0 0 0\n"): "not all finite",
    ("colmap", "1 EQUIRECTANGULAR 640 480 640 480\n"): "found 'EQUIRECTANGULAR'",
    (
        "colmap",
        "1 FULL_OPENCV 640 480 300 280 330 250 0 0 0 0 0 -9 0 0\n",
    ): "px RMS from every camera",
    ("colmap", "1 OPENCV 640 480 -300 280 330 250 0 0 0 0\n"): "field 'K'",
    ("ros", "image_width: 640\n"): "distortion_model: missing",
    ("ros", ROS): "camera_matrix: found 8 numbers, expected 9",
    ("opencv", ROS): "no matrices in XML or YAML of OpenCV",
    ("kalibr", ROS): "cam0: missing",
    ("kalibr", "a list\n"): "fields of another form",
    ("mrcal", "{'lensmodel': 'LENSMODEL_PINHOLE'}\n"): "intrinsics: missing",
    ("mrcal", "import os\n"): "not a camera of mrcal",
    ("opencv", "%YAML:1.0\n---\nimage_width: 640\n"): "camera_matrix: missing",
    ("opencv", "<xml\n"): "not a camera of opencv",
    ("ocamcalib", OCAM.replace("-150 0", "-150 nan")): "ss: found a1",
    ("ocamcalib", OCAM.replace("250 330", "250")): "not a camera of ocamcalib",
    ("ocamcalib", OCAM.replace("250 330", "250 inf")): "not all finite",
}


@pytest.mark.parametrize(("form", "text"), FAULTS)
def test_import_reports_a_fault_on_one_line(form, text, tmp_path):
    path = tmp_path / "camera.yml"
    path.write_text(text)
    with pytest.raises(InputError) as raised:
        import_camera(path, form)
    assert FAULTS[form, text] in str(raised.value)
    assert str(raised.value).startswith(f"{path}: ")
    assert "\n" not in str(raised.value)


def test_table_has_every_kind_and_format():
    """As `make test-formats` writes it: exact where the tests above are."""
    head, _, *lines = [x for x in TABLE.read_text().splitlines() if x.startswith("|")]
    formats = [cell.strip() for cell in head.split("|")][2:-1]
    cells = {row.split("|")[1].strip(): row.split("|")[2:-1] for row in lines}
    assert formats == list(FORMATS)
    for kind in KINDS:
        assert any(kind in name for name in cells)
    for form, name in CELLS:
        row = cells[f"{name} ({CAMERAS[name].kind})"]
        assert row[formats.index(form)].strip() == "exact"
