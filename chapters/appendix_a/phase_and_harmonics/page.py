# %% [markdown]
# # Appendix A: phases and harmonics
#
# **Question.** An active grid reads a place from four pictures of a sine.
# No monitor shows a true sine: its light rises as a power of its input.
# Which parts of that distortion move the decoded place, and by how much?

# %%
import numpy as np

from chapters.appendix_a.phase_and_harmonics.exercises import (
    alias_task,
    amplitude_task,
    steps_task,
)
from chapters.appendix_a.phase_and_harmonics.results import name_values
from chapters.appendix_a.phase_and_harmonics.trials import (
    AMPLITUDES,
    MOST_ORDER,
    ODD_AMPLITUDES,
    PHASES,
    SMALL,
    STEPS,
    error_orders,
    one_order,
    phases,
)
from chapters.shared.phase_steps import (
    decoder_error,
    formula_error,
    largest,
    phase_of,
    stepped,
    sum_of_orders,
)
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show_table("app_a")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - With four steps the even orders of the profile cancel: amplitudes of up
#   to 30 % change the phase by {glue:text}`even.formula:.0e` rad at most,
#   which is the rounding of the computer. The thesis is right.
# - Orders 3 and 5 do not cancel. They shift the phase to and fro four times
#   a period, by $(b_3 + b_5)/b_1$: 1 % of order 3 makes
#   {glue:text}`odd.one_percent:.4f` rad, or {glue:text}`odd.share:.2f` % of
#   a period.
# - Other numbers of steps have other blind orders: $N$ steps are disturbed by
#   the orders $mN - 1$ and $mN + 1$ only.
# - The ratio that the thesis ends with (A.9) is wrong in form; its
#   conclusion for order 2 stands.

# %% [markdown]
# ## What the thesis claims
#
# The pictures of a sine have grey values that repeat with the phase $\phi$,
# and any such profile is a Fourier series,
#
# $$I(\phi) = \frac{a_0}{2} + \sum_{n=1}^{\infty}
# a_n \cos n\phi + b_n \sin n\phi . \tag{A.1}$$
#
# Order 1 is the *fundamental*, the sine that was meant. All others are
# distortion. The thesis drops the constant and the cosines, writes down the
# four pictures, and finds that order 2, which it calls the first harmonic,
# leaves the decoded phase as it is. In 3.2.2 it says so of all "odd
# harmonics". In the count of this page these are the *even* orders 2, 4,
# 6 (E-3.09): the first harmonic is order 2, the third is order 4.

# %% [markdown]
# ## Model
#
# **Four steps.** Each picture is advanced by a quarter of a period,
# $I_{k+1}(\phi) = I(\phi + k\pi/2)$ for $k = 0$ to 3 (A.3 to A.6). The
# decoder takes two differences. A constant is in both pictures of each, and
# goes. Half a period changes the sign of odd orders, and leaves even ones
# alone: $\sin n(\phi + \pi) = (-1)^n \sin n\phi$, and cosines alike. So
#
# $$I_1 - I_3 = 2\sum_{n\ \mathrm{odd}} a_n \cos n\phi + b_n \sin n\phi ,
# \tag{A.7}$$
#
# The second pair is a quarter of a period further on. For odd $n$ that
# makes a cosine of a sine, $\sin(n\phi + n\pi/2) = (-1)^{(n-1)/2}\cos
# n\phi$, and a sine of opposite sign of a cosine, so that
#
# $$I_2 - I_4 = 2\sum_{n\ \mathrm{odd}} (-1)^{\frac{n-1}{2}}
# \left(b_n \cos n\phi - a_n \sin n\phi\right) . \tag{A.8}$$
#
# Every even order is gone, sine or cosine. That matters: the profile of a
# gamma has its order 2 as a cosine, which the thesis had assumed away
# (E-3.11). (A.7) and (A.8) are printed with sums over all $n$; they run
# over odd $n$ only.
#
# **The right ratio.** With sines alone,
#
# $$\frac{I_1 - I_3}{I_2 - I_4} = \frac{b_1 \sin\phi + b_3 \sin 3\phi + b_5
# \sin 5\phi + \dots}{b_1 \cos\phi - b_3 \cos 3\phi + b_5 \cos 5\phi -
# \dots} . $$
#
# The thesis divides term by term and adds up, $\tan\phi - \tan 3\phi +
# \tan 5\phi - \dots$ (A.9). A ratio of sums is not the sum of ratios, and
# the sizes $b_n$ would have no say (E-3.10). For $b_3 = 0.05\,b_1$ at $\phi
# = 0.4$ rad the ratio is {glue:text}`ratio.true:.3f`; the first two terms
# of (A.9) make {glue:text}`ratio.printed:.2f`. Without odd orders above the
# first, both are $\tan\phi$.
#
# **From the ratio to the error.** The phase is the angle of the point
# $(I_2 - I_4,\ I_1 - I_3)$, in all four quadrants (E-3.08); a plain arctan
# knows half a period only. Take that point as a complex number and divide
# by the right one, $2 b_1 e^{i\phi}$:
#
# $$1 + \frac{b_5}{b_1} e^{4i\phi} - \frac{b_3}{b_1} e^{-4i\phi} + \dots$$
#
# What is added to 1 is small, so the angle is its imaginary part:
#
# $$\text{phase error} \approx \frac{b_3 + b_5}{b_1} \sin 4\phi .$$
#
# **Any number of steps.** The decoder adds up $N$ pictures, advanced by
# $2\pi k/N$ each, with weights $e^{-2\pi i k/N}$; for four steps this is the
# point above. What a term $e^{in\phi}$ of the profile leaves is
#
# $$\sum_{k=0}^{N-1} e^{in(\phi + 2\pi k/N)}\, e^{-2\pi i k/N} = \begin{cases}
# N e^{in\phi} & n - 1 \text{ a multiple of } N \\ 0 & \text{else.}
# \end{cases}$$
#
# A sine or cosine of order $n$ is made of $e^{in\phi}$ and $e^{-in\phi}$. So
# only the orders $mN - 1$ and $mN + 1$, $m = 1, 2, \dots$, disturb:
#
# $$\text{phase error} \approx \sum_m \frac{b_{mN-1} + b_{mN+1}}{b_1} \sin
# mN\phi + \frac{a_{mN-1} + a_{mN+1}}{b_1} \cos mN\phi .$$
#
# **What a gamma makes.** Light is value to the power $\gamma$, and the
# value is $\tfrac12 + \tfrac12\sin\phi = \cos^2(\psi/2)$ with $\psi = \phi -
# \pi/2$, counted from where it is brightest. The light is even in $\psi$, a
# sum of $A_n \cos n\psi$. These are sines of $n\phi$ for odd $n$ and cosines
# for even $n$. Its slope obeys $(1 + \cos\psi)\, I' = -\gamma \sin\psi\, I$,
# and the parts of this with $\sin n\psi$ say
#
# $$2 n A_n = (\gamma - n + 1) A_{n-1} - (\gamma + n + 1) A_{n+1} . $$
#
# The amplitudes that solve it follow one from the other,
#
# $$\frac{A_{n+1}}{A_n} = \frac{\gamma - n}{\gamma + n + 1} .$$
#
# At $\gamma = 2.2$ order 2 has {glue:text}`law.two:.0f` % of order 1, and
# order 3 only {glue:text}`law.three:.1f` %. At $\gamma = 1$ there is no
# order 2, at $\gamma = 2$ no order 3. A black level adds a constant, and
# changes nothing.

# %% tags=["active-ipynb"]
# show_code(stepped, phase_of)

# %% [markdown]
# ## Experiment
#
# Each profile is evaluated twice: by (3.23) in double precision, and by the
# library's decoder from images of 16 bits.


# %%
def even_trial(condition, rng):
    """Largest phase error that one even order makes, rad."""
    phase = phases(condition["phases"])
    formula, decoder = [], []
    for amplitude in AMPLITUDES:
        profile = one_order(condition["order"], condition["kind"], amplitude)
        formula.append(largest(formula_error(profile, 4, phase)))
        decoder.append(largest(decoder_error(profile, 4, len(phase))[1]))
    return {"formula_rad": max(formula), "decoder_rad": max(decoder)}


@experiment("exp_c3_even_cancels", artefact="app_a")
def even_orders(effort):
    """Orders 2, 4 and 6, sine and cosine, up to 30 % of the first."""
    conditions = crossed(
        order=(2, 4, 6), kind=("sine", "cosine"), phases=[PHASES[effort]]
    )
    return Plan(even_trial, conditions, 1, {"amplitudes": list(AMPLITUDES)})


# %%
def odd_trial(condition, rng):
    """The error that orders 3 and 5 make: its size, and how it oscillates."""
    phase = phases(condition["phases"])
    profile = sum_of_orders({1: 1.0, 3: condition["b3"], 5: condition["b5"]})
    error = formula_error(profile, 4, phase)
    parts = error_orders(error)
    decoded = decoder_error(profile, 4, len(phase))[1]
    return {
        "amplitude_rad": float(parts[4]),
        "largest_rad": largest(error),
        "strongest_order": int(np.argmax(parts)),
        "decoder_apart_rad": largest(decoded - error),
        "error": error.astype(np.float32),
    }


@experiment("exp_c3_odd_orders_matter", artefact="app_a")
def odd_orders(effort):
    """Orders 3 and 5, each up to 5 % of the first, and together."""
    conditions = [
        {"b3": b3, "b5": b5, "phases": PHASES[effort]}
        for b3 in ODD_AMPLITUDES
        for b5 in ODD_AMPLITUDES
        if b3 + b5
    ]
    return Plan(odd_trial, conditions, 1)


# %%
def order_trial(condition, rng):
    """Largest phase error of N steps by 1 % of each order, sine and cosine."""
    phase = phases(condition["phases"])
    found = {}
    for kind in ("sine", "cosine"):
        for order in range(2, MOST_ORDER + 1):
            profile = one_order(order, kind, SMALL)
            error = formula_error(profile, condition["steps"], phase)
            found[f"{kind}.{order}"] = largest(error)
    return found


@experiment("ext_orders_of_steps", artefact="ext_orders_of_steps")
def order_sweep(effort):
    """Every order up to 17, for 3, 4, 5, 6 and 8 steps."""
    conditions = crossed(steps=STEPS, phases=[PHASES[effort]])
    return Plan(order_trial, conditions, 1, {"amplitude": SMALL})


# %% [markdown]
# ## Figures

# %% tags=["active-ipynb"]
# show("ext_orders_of_steps")

# %% [markdown]
# ## Reading and limits
#
# - **Amplitudes add with their signs.** Orders 3 and 5 of opposite signs
#   work against each other. The test of the claim takes both positive, so
#   that their sum cannot vanish.
# - **The error is not noise.** It has the same sign at the same place of
#   every cell. Averaging over neighbours removes none of it unless the
#   average spans a good part of its wave, a quarter of a period for four
#   steps. Read as here, with `--linear`, the decoder's standard deviation
#   leaves it out; else it measures the error and undoes it.
# - **Odd or even.** An even number of steps hears odd orders only. Three
#   steps hear orders 2 and 4, and order 2 is the strongest that a monitor
#   has. Five hear 4 and 6.
# - **Cut-off values** have corners, and corners have orders that fall off
#   slowly, so that every number of steps meets some of them. The cure is
#   not more steps but less contrast.
# - **The camera counts as well.** $I(\phi)$ is what the file holds; a
#   camera's own tone curve is one more response after the monitor's. A
#   camera that is made for sRGB undoes most of the monitor's gamma.
# - **Thesis and symbols.** (A.2) takes the profile as a sum of sines. For a
#   gamma it is one of sines of odd and cosines of even order; the tables
#   here test both kinds.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** A monitor has a gamma of 1.8. How large is $A_3/A_1$? A share of 1 % is
# 0.01; the sign counts.

# %% tags=["active-ipynb"]
# check(None, **amplitude_task())

# %% [markdown]
# **2.** Which two orders above the first, as a list, are the lowest that
# disturb seven steps?

# %% tags=["active-ipynb"]
# check(None, **alias_task())

# %% [markdown]
# **3.** A profile has $b_3 = -0.02\,b_1$ and $b_5 = 0.012\,b_1$. A cell is
# 40 mm wide. By how many mm, at most, is a place wrong with four steps?

# %% tags=["active-ipynb"]
# check(None, **steps_task())
