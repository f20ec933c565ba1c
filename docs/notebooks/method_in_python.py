# %% [markdown]
# # Write a method in Python
#
# Use this notebook when no method of Tumble answers your question. You write a function that gets recordings and returns parameters with
# their covariance, and a trial: simulated recordings whose truth is known. Tumble runs the method like any other, and tells you whether
# its intervals hold the truth as often as they say.

# %%
import numpy as np

import tumble


def identify(recordings, settings):
    """Drift of a gyro at rest: a straight line through its samples, with white noise."""
    channel = recordings[0]["gyro.x"]
    time, rate = channel.times - channel.times.mean(), channel.in_("deg/h")
    columns = np.column_stack([np.ones_like(time), time / 3600])
    inverse = np.linalg.inv(columns.T @ columns)
    coefficients = inverse @ columns.T @ rate
    residuals = rate - columns @ coefficients
    variance = residuals @ residuals / (len(rate) - 2)
    return {"bias": (coefficients[0], "deg/h"), "drift": (coefficients[1], "deg/h/h")}, variance * inverse


def trial(seed):
    """Half an hour at 1 Hz, with a bias of 2 deg/h and a drift of 0.3 deg/h an hour."""
    time = np.arange(1800.0)
    rate = 2.0 + 0.3 * (time - time.mean()) / 3600 + np.random.default_rng(seed).normal(0, 0.5, len(time))
    return [tumble.from_arrays({"gyro.x": (rate, "deg/h")}, rate=1)], {"bias": 2.0, "drift": 0.3}


drift = tumble.Method("drift_at_rest", "bias and drift of a gyro at rest", identify, trial)

# %%
recordings, truth = trial(seed=1)
tumble.identify(drift, *recordings)

# %%
for line in tumble.coverage(drift, seeds=200):
    print(f"{line.parameter}: the interval held the truth in {line.fraction:.1%}, allowed {line.allowed}, holds: {line.holds}")

# %% [markdown]
# The same question with noise that walks: the intervals are too narrow, and the coverage says so.


# %%
def walking(seed):
    given, truth = trial(seed)
    walk = np.cumsum(np.random.default_rng(10_000 + seed).normal(0, 0.01, 1800))
    return [tumble.from_arrays({"gyro.x": (given[0]["gyro.x"].in_("deg/h") + walk, "deg/h")}, rate=1)], truth


for line in tumble.coverage(drift._replace(trial=walking), seeds=200):
    print(f"{line.parameter}: {line.fraction:.1%}, holds: {line.holds}")
