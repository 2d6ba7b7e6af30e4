# %% [markdown]
# # Appendix A: phases and harmonics
#
# **Question.** An active grid decodes a position from four images of a sinusoid, but
# no monitor displays an exact sinusoid. Its light rises as a power of its input,
# which adds harmonics. Which harmonics change the decoded phase, and by how much? The
# thesis answers for order 2.

# %%
import numpy as np

from chapters.appendix_a.phase_and_harmonics.exercises import (
    alias_task,
    amplitude_task,
    steps_task,
)
from chapters.appendix_a.phase_and_harmonics.experiment import (
    AMPLITUDES,
    MAX_ORDER,
    ODD_AMPLITUDES,
    PHASES,
    SMALL,
    STEPS,
    error_orders,
    one_order,
    phases,
)
from chapters.appendix_a.phase_and_harmonics.report import name_values
from chapters.shared.grids import (
    decoder_error,
    formula_error,
    largest,
    phase_of,
    stepped,
    sum_of_orders,
)
from repro.page import check, compared, open_results, show, show_code, show_table
from repro.run import Plan, crossed, experiment

# %% tags=["active-ipynb"]
# show_table("app_a")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# 1. **Even orders cancel with four steps.** The phase changes by rounding errors
#    only, as the thesis states, for sines and cosines.
# 2. **Orders 3 and 5 do not cancel.** They add a ripple of four waves per period: 1 %
#    of order 3 gives {glue:text}`odd.one_percent:.4f` rad, or
#    {glue:text}`odd.share:.2f` % of a period.
# 3. **The rule for $N$ steps.** Only orders $mN - 1$ and $mN + 1$ disturb the phase.
# 4. **The final ratio of the thesis is wrong in form.** (A.9) adds ratios term by
#    term. Its conclusion for order 2 is right.

# %% [markdown]
# | quantity | thesis | here |
# |---|---|---|
# | phase error by order 2, four steps | 0 | 0 |
# | phase error by orders 4 and 6 | 0 (3.2.2) | 0 |
# | by 1 % of order 3 | not stated | {glue:text}`odd.one_percent:.4f` rad |
# | intensity ratio (A.9) | sum of tangents | ratio of two sums |

# %% [markdown]
# ## Terms
#
# - *Active grid*: phase-shift structured light, displayed on a monitor.
# - *Profile* $I(\phi)$: grey value as a function of the phase $\phi$.
# - *Order* $n$: Fourier component $\cos n\phi$, $\sin n\phi$ with coefficients $a_n$,
#   $b_n$. Order 1 is the *fundamental*. The "odd harmonics" of the thesis are the
#   even orders 2, 4, 6 (E-3.09).
# - $N$, $I_1 \dots I_N$: number of phase steps, and the images of one pixel. The
#   shift is $2\pi/N$.
# - *Phase error*: decoded phase minus $\phi$.
# - $\gamma$: exponent of the monitor's response. $A_n$: its Fourier coefficients.
# - (3.23): the decoder, the angle of the point $(I_2 - I_4,\ I_1 - I_3)$.

# %% [markdown]
# ## What the thesis claims
#
# The grey values of a pixel repeat with the phase, and any such profile is a Fourier
# series,
#
# $$I(\phi) = \frac{a_0}{2} + \sum_{n=1}^{\infty}
# a_n \cos n\phi + b_n \sin n\phi . \tag{A.1}$$
#
# The thesis assumes $a_n = 0$ (A.2) and concludes that order 2 leaves the decoded
# phase unchanged. Section 3.2.2 extends this to all "odd harmonics".

# %% [markdown]
# ## Model
#
# **Four steps.** Each image is shifted by a quarter of a period,
# $I_{k+1}(\phi) = I(\phi + k\pi/2)$ for $k = 0$ to 3 (A.3 to A.6). The decoder uses
# two differences. Half a period changes the sign of odd orders and leaves even orders
# unchanged:
# $\sin n(\phi + \pi) = (-1)^n \sin n\phi$, and the same for cosines. Therefore
#
# $$I_1 - I_3 = 2\sum_{n\ \mathrm{odd}} a_n \cos n\phi + b_n \sin n\phi .
# \tag{A.7}$$
#
# The second pair is shifted by a quarter of a period. For odd $n$,
# $\sin(n\phi + n\pi/2) = (-1)^{(n-1)/2}\cos n\phi$. A cosine becomes a sine of the
# opposite sign. Therefore
#
# $$I_2 - I_4 = 2\sum_{n\ \mathrm{odd}} (-1)^{\frac{n-1}{2}}
# \left(b_n \cos n\phi - a_n \sin n\phi\right) . \tag{A.8}$$
#
# All even orders vanish, sines and cosines. The order 2 of a gamma profile is a
# cosine, which the thesis assumes to be zero (E-3.11). It prints the sums over all
# $n$; they run over odd $n$ only.
#
# **The exact ratio.** With sines alone,
#
# $$\frac{I_1 - I_3}{I_2 - I_4} = \frac{b_1 \sin\phi + b_3 \sin 3\phi + b_5
# \sin 5\phi + \dots}{b_1 \cos\phi - b_3 \cos 3\phi + b_5 \cos 5\phi -
# \dots} . $$
#
# The thesis divides term by term and obtains
# $\tan\phi - \tan 3\phi + \tan 5\phi - \dots$ (A.9), which does not depend on the
# $b_n$ (E-3.10). For $b_3 = 0.05\,b_1$
# at $\phi = 0.4$ rad the exact ratio is {glue:text}`ratio.true:.3f`. The first two
# terms of (A.9) give {glue:text}`ratio.printed:.2f`.
#
# **Phase error.** The phase is the angle of the point $(I_2 - I_4,\ I_1 - I_3)$ in
# all four quadrants (E-3.08). Take that point as a complex number and divide by its
# ideal value $2 b_1 e^{i\phi}$:
#
# $$1 + \frac{b_5}{b_1} e^{4i\phi} - \frac{b_3}{b_1} e^{-4i\phi} + \dots$$
#
# The terms added to 1 are small, so the angle is their imaginary part:
#
# $$\text{phase error} \approx \frac{b_3 + b_5}{b_1} \sin 4\phi .$$
#
# **Any number of steps.** The decoder sums $N$ images, shifted by $2\pi k/N$, with
# weights $e^{-2\pi i k/N}$. For $N = 4$ the sum is the point above. A term
# $e^{in\phi}$ of the profile contributes
#
# $$\sum_{k=0}^{N-1} e^{in(\phi + 2\pi k/N)}\, e^{-2\pi i k/N} = \begin{cases}
# N e^{in\phi} & n - 1 \text{ a multiple of } N \\ 0 & \text{else.}
# \end{cases}$$
#
# A sine or cosine of order $n$ consists of $e^{in\phi}$ and $e^{-in\phi}$. So only
# the orders $mN - 1$ and $mN + 1$, $m = 1, 2, \dots$, disturb the phase:
#
# $$\text{phase error} \approx \sum_m \frac{b_{mN-1} + b_{mN+1}}{b_1} \sin
# mN\phi + \frac{a_{mN-1} + a_{mN+1}}{b_1} \cos mN\phi .$$
#
# **Orders of a gamma profile.** The light is the input to the power $\gamma$. The
# input is $\tfrac12 + \tfrac12\sin\phi = \cos^2(\psi/2)$, with $\psi = \phi - \pi/2$
# measured from the maximum. The light is an even function of $\psi$, a sum of
# $A_n \cos n\psi$. These are sines of $n\phi$ for odd $n$ and cosines for even $n$.
# The light satisfies $(1 + \cos\psi)\, I' = -\gamma \sin\psi\, I$. The coefficients
# of $\sin n\psi$ give
#
# $$2 n A_n = (\gamma - n + 1) A_{n-1} - (\gamma + n + 1) A_{n+1} , $$
#
# with the solution
#
# $$\frac{A_{n+1}}{A_n} = \frac{\gamma - n}{\gamma + n + 1} .$$
#
# At $\gamma = 2.2$ order 2 has {glue:text}`law.two:.0f` % of order 1, and order 3
# only {glue:text}`law.three:.1f` %. At $\gamma = 1$ there is no order 2, at
# $\gamma = 2$ no order 3. A black level cancels.

# %% tags=["active-ipynb"]
# show_code(stepped, phase_of)

# %% [markdown]
# ## Experiment
#
# Each profile is evaluated twice: by (3.23) in double precision, and by the library's
# decoder from 16-bit images. Even orders have up to 30 % of the fundamental, odd
# orders up to 5 %.


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
    """Amplitude and strongest order of the error by orders 3 and 5."""
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
        for order in range(2, MAX_ORDER + 1):
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
# ## Orders that disturb $N$ steps

# %% tags=["active-ipynb"]
# show("ext_orders_of_steps")

# %% [markdown]
# ## Discussion
#
# - **Amplitudes add with their signs.** Orders 3 and 5 of opposite signs compensate.
#   The test of the claim takes both positive.
# - **The error is not noise.** It has the same sign at the same position of every
#   cell.
# - **Predicted standard deviation.** With `--linear`, as here, that of the decoder
#   excludes this error. By default the decoder measures and corrects the error.
# - **Parity.** Three steps are disturbed by order 2, the strongest of a monitor.
# - **Saturation.** Clipped grey values have orders that decrease slowly, so every
#   number of steps is affected. The remedy is less contrast.
# - **The camera.** $I(\phi)$ is the profile in the image file, so the camera's tone
#   curve is included.

# %% [markdown]
# ## Summary
#
# The thesis's conclusion is right: with four steps, even orders do not change the
# decoded phase. Its last formula (A.9) is wrong, and odd orders disturb the phase in
# proportion to their amplitude. With $N$ steps the orders $mN \pm 1$ disturb it.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an answer in
# place of `None`, and run that cell again.
#
# **1.** A monitor has a gamma of 1.8. How large is $A_3/A_1$, with its sign? A share
# of 1 % is 0.01.

# %% tags=["active-ipynb"]
# check(None, **amplitude_task())

# %% [markdown]
# **2.** Which two orders above the first, as a list, are the lowest that disturb
# seven steps?

# %% tags=["active-ipynb"]
# check(None, **alias_task())

# %% [markdown]
# **3.** A profile has $b_3 = -0.02\,b_1$ and $b_5 = 0.012\,b_1$. A cell is 40 mm
# wide. How large, in mm, is the largest position error with four steps?

# %% tags=["active-ipynb"]
# check(None, **steps_task())
