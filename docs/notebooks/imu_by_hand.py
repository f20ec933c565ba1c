# %% [markdown]
# # Calibrate an IMU by hand
#
# Use this notebook when you have no rate table. You lay the IMU down in 24 ways, each for eight seconds, and turn it by hand in
# between. No angle needs to be known. You get bias, scale factor and misalignment of both triads with their uncertainties.
#
# The recording is simulated, so that the truth is known. With your own, replace `simulate` by `tumble.read`.

# %%
import warnings

import tumble

warnings.simplefilter("ignore", tumble.TumbleWarning)
plan = tumble.load_plan("plans/imu_multi_position.toml")
recording = tumble.simulate(plan, seed=11)
recording

# %%
result = tumble.identify(plan, recording)
result

# %% [markdown]
# Is the answer true? Each parameter is compared with the truth of the simulation: the difference over the standard uncertainty
# should be within two for nineteen of twenty.

# %%
truth = tumble.predict(plan)  # the values of a prediction are the truth of the plan
for name, parameter in result.parameters.items():
    if name in truth.parameters:
        true = truth.parameters[name].in_(parameter.unit).value
        print(f"{name:40} {(parameter.value - true) / parameter.sd:6.2f}")

# %% [markdown]
# Subtract the identified errors from another recording of the same IMU.

# %%
other = tumble.simulate(plan, seed=12)
better = tumble.compensate(result, other)
better
