# %% [markdown]
# # The rigs of the laboratory
#
# **Question.** What stands where when the laboratory takes its photographs?
# The rigs of `data/rigs` in three dimensions: the camera, its mirror, how
# far it sees, and its targets. Left out are those whose name ends in
# `-small`: they have fewer pixels, and some of them a part moved. Turn them
# around, and look at your own in the same way.

# %%
from chapters.guides.rigs.results import facts
from chapters.guides.rigs.trials import FILES, NAMES, SEED, rig_trial
from repro.page.reader import open_results, show, show_code, show_table, value
from repro.run.experiment import experiment
from repro.run.outcomes import Plan


# %%
@experiment("ext_rigs", artefact="ext_rigs", inputs=FILES)
def ext_rigs(effort):
    """Poses of the targets of every rig, and its sizes."""
    conditions = [{"rig": name} for name in NAMES]
    return Plan(rig_trial, conditions, 1, {"seed": SEED})


# %% tags=["active-ipynb", "remove-input"]
# for name, x in facts(open_results("ext_rigs")).items(): value(name, x)

# %% tags=["active-ipynb", "remove-input"]
# value("seed", SEED)

# %% tags=["active-ipynb"]
# show_table("ext_rigs_in_numbers", digits=3)

# %% [markdown]
# ## Findings
#
# - {glue:text}`rigs` rigs are on this page. Their cameras see from
#   {glue:text}`least_deg`° to {glue:text}`most_deg`°.
# - In {glue:text}`whole` of {glue:text}`poses` poses the whole target is in
#   the picture.

# %% [markdown]
# ## How to look at one
#
# A rig is a file that says what stands before what, each length with its
# unit, its origin and its reason. The pictures below are drawn from these
# files by one command, which takes any other rig as well:
#
# ```
# raxel show data/rigs/ordinary-lens.yaml --out scene.html
# raxel show data/rigs/ordinary-lens.yaml --out picture.png --seed 3
# ```
#
# Without `--out` it opens the scene in a browser. Copy a rig, change a
# number, look again; a rig whose camera cannot see its targets is refused
# in one line. `raxel render` then takes the photographs, of the same poses
# if the seed is the same; here it is {glue:text}`seed`. The numbers beside a
# figure (CSV) are those poses. The command draws a camera (`camera.npz`) or
# an image set in the same way. What the rendered sets are good for is on
# the page [Benchmarks](benchmarks.ipynb).
#
# **What is drawn.** The frame is the camera's, z ahead and y down. A target
# shows its squares from the side that faces the camera; from behind one
# looks through it. The edge of the field of view is drawn as a ring at one
# distance from where its rays start. Distances and tilts below count from
# the point that is nearest to all rays: the centre, if the camera has one.

# %% tags=["active-ipynb"]
# show_code(rig_trial)

# %% [markdown]
# ## Ordinary cameras
#
# ### `ordinary-lens`: the easy case, which nothing should fail
#
# {glue:text}`ordinary_lens.summary`. {glue:text}`ordinary_lens.sizes`. Used
# by [Benchmarks](benchmarks.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_ordinary_lens")

# %% [markdown]
# ### `active-grid-demo`: a monitor that gives every pixel a point
#
# {glue:text}`active_grid_demo.summary`.
# {glue:text}`active_grid_demo.sizes`. Used by
# [Benchmarks](benchmarks.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_active_grid_demo")

# %% [markdown]
# ## A fisheye converter at three zooms
#
# One lens, three fields of view. Table 2.2 compares a pinhole with a
# general camera on these.
#
# ### `coolpix-fce8-zoom-1`: zoomed in
#
# {glue:text}`coolpix_fce8_zoom_1.summary`.
# {glue:text}`coolpix_fce8_zoom_1.sizes`. Used by [section
# 2.5.2](../ch02_general_camera_model/s5_2_real_data.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_coolpix_fce8_zoom_1")

# %% [markdown]
# ### `coolpix-fce8-zoom-2`: half way
#
# {glue:text}`coolpix_fce8_zoom_2.summary`.
# {glue:text}`coolpix_fce8_zoom_2.sizes`. Used by [section
# 2.5.2](../ch02_general_camera_model/s5_2_real_data.ipynb), and before a
# building front by [section
# 2.5.3](../ch02_general_camera_model/s5_3_distortion_correction.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_coolpix_fce8_zoom_2")

# %% [markdown]
# ### `coolpix-fce8-zoom-3`: the whole fisheye
#
# {glue:text}`coolpix_fce8_zoom_3.summary`.
# {glue:text}`coolpix_fce8_zoom_3.sizes`. Used by [section
# 2.5.2](../ch02_general_camera_model/s5_2_real_data.ipynb), and as a lens
# to fit by [section
# 2.2](../ch02_general_camera_model/s2_camera_models.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_coolpix_fce8_zoom_3")

# %% [markdown]
# ## All around
#
# ### `panorama-hyperboloid`: the mirror of Fig. 1.1
#
# {glue:text}`panorama_hyperboloid.summary`.
# {glue:text}`panorama_hyperboloid.sizes`. Used by [section
# 1.1.2](../ch01_introduction/s1_1_panorama.ipynb), which shows it in its
# room.

# %% tags=["active-ipynb"]
# show("ext_rig_panorama_hyperboloid")

# %% [markdown]
# ## Active grids
#
# Monitors that give every pixel a point, where chessboards do badly or not
# at all.
#
# ### `d200-fisheye`: a fisheye before a monitor
#
# {glue:text}`d200_fisheye.summary`. {glue:text}`d200_fisheye.sizes`. Used
# by [section 3.3.4](../ch03_planar_grids/s3_4_active_grid_images.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_d200_fisheye")

# %% [markdown]
# ### `monitor-d200`: a chessboard and an active grid in one place
#
# {glue:text}`monitor_d200.summary`. {glue:text}`monitor_d200.sizes`. Used by
# [section 3.3.3](../ch03_planar_grids/s3_3_active_grid_robustness.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_monitor_d200")

# %% [markdown]
# ### `d200-lens`: an ordinary lens before a monitor
#
# {glue:text}`d200_lens.summary`. {glue:text}`d200_lens.sizes`. Used
# by [section 3.3.4](../ch03_planar_grids/s3_4_active_grid_images.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_d200_lens")

# %% [markdown]
# ### `d200-lens-sharp`: the same with sharper edges
#
# {glue:text}`d200_lens_sharp.summary`. {glue:text}`d200_lens_sharp.sizes`. Used
# by [section 3.3.4](../ch03_planar_grids/s3_4_active_grid_images.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_d200_lens_sharp")

# %% [markdown]
# ### `d200-boards`: its calibration
#
# {glue:text}`d200_boards.summary`. {glue:text}`d200_boards.sizes`. Used
# by [section 3.3.4](../ch03_planar_grids/s3_4_active_grid_images.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_d200_boards")

# %% [markdown]
# ### `mirror-ball`: a monitor in pieces
#
# {glue:text}`mirror_ball.summary`. {glue:text}`mirror_ball.sizes`. Used
# by [section 3.3.4](../ch03_planar_grids/s3_4_active_grid_images.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_mirror_ball")

# %% [markdown]
# ### `kodak-megaplus`: a perspective camera before a monitor
#
# {glue:text}`kodak_megaplus.summary`. {glue:text}`kodak_megaplus.sizes`. Used by
# [section 4.2](../ch04_central_generic/s2_pose.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_kodak_megaplus")

# %% [markdown]
# ### `kodak-boards`: its calibration
#
# {glue:text}`kodak_boards.summary`. {glue:text}`kodak_boards.sizes`. Used by
# [section 4.2](../ch04_central_generic/s2_pose.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_kodak_boards")

# %% [markdown]
# ### `onevr-d70`: a mirror all around before a monitor
#
# {glue:text}`onevr_d70.summary`.
# {glue:text}`onevr_d70.sizes`. Used by [section
# 4.3.1](../ch04_central_generic/s3_1_setup.ipynb) and those after it.

# %% tags=["active-ipynb"]
# show("ext_rig_onevr_d70")

# %% [markdown]
# ### `onevr-d70-boards`: boards to correct
#
# {glue:text}`onevr_d70_boards.summary`.
# {glue:text}`onevr_d70_boards.sizes`. Used by [section
# 4.3.1](../ch04_central_generic/s3_1_setup.ipynb) and those after it.

# %% tags=["active-ipynb"]
# show("ext_rig_onevr_d70_boards")

# %% [markdown]
# ### `coolpix-4500-fce8`: the whole fisheye before a monitor
#
# {glue:text}`coolpix_4500_fce8.summary`.
# {glue:text}`coolpix_4500_fce8.sizes`. Used by [section
# 4.3.1](../ch04_central_generic/s3_1_setup.ipynb) and those after it.

# %% tags=["active-ipynb"]
# show("ext_rig_coolpix_4500_fce8")

# %% [markdown]
# ### `coolpix-4500-fce8-boards`: boards to correct
#
# {glue:text}`coolpix_4500_fce8_boards.summary`.
# {glue:text}`coolpix_4500_fce8_boards.sizes`. Used by [section
# 4.3.1](../ch04_central_generic/s3_1_setup.ipynb) and those after it.

# %% tags=["active-ipynb"]
# show("ext_rig_coolpix_4500_fce8_boards")

# %% [markdown]
# ## The four sets of planar grids
#
# Chessboards that are hard to find: [section
# 3.3.2](../ch03_planar_grids/s3_2_grid_sets.ipynb) counts the corners found
# in each set, and [its conditions](../ch03_planar_grids/s3_2_conditions.ipynb)
# are looked at one by one.
#
# ### `spherical`: in a ball
#
# {glue:text}`spherical.summary`. {glue:text}`spherical.sizes`. Used by
# [section 3.3.2](../ch03_planar_grids/s3_2_grid_sets.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_spherical")

# %% [markdown]
# ### `hyperboloidal`: in a hyperboloid
#
# {glue:text}`hyperboloidal.summary`. {glue:text}`hyperboloidal.sizes`. Used
# by [section 3.3.2](../ch03_planar_grids/s3_2_grid_sets.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_hyperboloidal")

# %% [markdown]
# ### `fisheye-9x7`: in a fisheye, the smaller grid
#
# {glue:text}`fisheye_9x7.summary`. {glue:text}`fisheye_9x7.sizes`. Used by
# [section 3.3.2](../ch03_planar_grids/s3_2_grid_sets.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_fisheye_9x7")

# %% [markdown]
# ### `fisheye-12x9`: in a fisheye, the larger grid
#
# {glue:text}`fisheye_12x9.summary`. {glue:text}`fisheye_12x9.sizes`. Used
# by [section 3.3.2](../ch03_planar_grids/s3_2_grid_sets.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_fisheye_12x9")

# %% [markdown]
# ### `flexible-mirror`: in a bent mirror
#
# {glue:text}`flexible_mirror.summary`. {glue:text}`flexible_mirror.sizes`.
# Used by [section 3.3.2](../ch03_planar_grids/s3_2_grid_sets.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_flexible_mirror")

# %% [markdown]
# ## A mirror that bends
#
# Chapter 5: a sheet of mirror clamped at one edge and pushed near the other,
# here as it is at stage 0, flat. Two geometries, so that one sees how much
# hangs on them; each before a chessboard, and before a monitor in the two
# positions of primary calibration.
#
# ### `flexible-mirror-a`: far from the sheet
#
# {glue:text}`flexible_mirror_a.summary`.
# {glue:text}`flexible_mirror_a.sizes`.

# %% tags=["active-ipynb"]
# show("ext_rig_flexible_mirror_a")

# %% [markdown]
# ### `flexible-mirror-a-monitor`: the same, before a monitor
#
# {glue:text}`flexible_mirror_a_monitor.summary`.
# {glue:text}`flexible_mirror_a_monitor.sizes`.

# %% tags=["active-ipynb"]
# show("ext_rig_flexible_mirror_a_monitor")

# %% [markdown]
# ### `flexible-mirror-b`: nearer and wider
#
# {glue:text}`flexible_mirror_b.summary`.
# {glue:text}`flexible_mirror_b.sizes`.

# %% tags=["active-ipynb"]
# show("ext_rig_flexible_mirror_b")

# %% [markdown]
# ### `flexible-mirror-b-monitor`: the same, before a monitor
#
# {glue:text}`flexible_mirror_b_monitor.summary`.
# {glue:text}`flexible_mirror_b_monitor.sizes`.

# %% tags=["active-ipynb"]
# show("ext_rig_flexible_mirror_b_monitor")

# %% [markdown]
# ## Large grids without a border
#
# Fig. 3.14: one board that takes up much of the picture.
#
# ### `large-hyperboloidal`: in a hyperboloid
#
# {glue:text}`large_hyperboloidal.summary`.
# {glue:text}`large_hyperboloidal.sizes`. Used by [the conditions of section
# 3.3.2](../ch03_planar_grids/s3_2_conditions.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_large_hyperboloidal")

# %% [markdown]
# ### `large-fisheye`: in a fisheye
#
# {glue:text}`large_fisheye.summary`. {glue:text}`large_fisheye.sizes`. Used
# by [the conditions of section
# 3.3.2](../ch03_planar_grids/s3_2_conditions.ipynb).

# %% tags=["active-ipynb"]
# show("ext_rig_large_fisheye")

# %% [markdown]
# ## Limits
#
# - A scene has the geometry of a rig and nothing of its light: lens blur,
#   noise, dirt and shadows are in the rig file and in its photographs.
# - The monitor shows a coarse pattern of stripes that stands for all that it
#   shows in turn.
# - Mirrors do not reflect here. What the camera sees in one is in its
#   photograph.
