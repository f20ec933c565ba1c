# %% [markdown]
# # A fibre-optic gyro over temperature
#
# Use this notebook for the bias of a fibre-optic gyro over temperature, its gradient and its rate. You need a recording of soaks and
# ramps in a chamber with two temperature sensors. You get a model, whose terms are chosen by the data, and the bias that remains.

# %%
import warnings

import tumble

warnings.simplefilter("ignore", tumble.TumbleWarning)
plan = tumble.load_plan("plans/fog_thermal_bias.toml")
test = tumble.simulate(plan, seed=1)
result = tumble.identify(plan, test)
result

# %%
for verdict in result.verdicts:
    print(verdict.parameter, verdict.outcome, verdict.limit)
for name in ("bias_sd_raw", "bias_sd_compensated", "bias_sd_held_out"):
    print(result.parameters[name])

# %% [markdown]
# Compensate another test of the same gyro. `.compensation_sd` says how well the correction is known at each sample, `.extrapolated`
# where the temperature is outside of what the calibration covered. The white noise of a single sample remains.

# %%
other = tumble.simulate(plan, seed=2)
better = tumble.compensate(result, other)
print(other["gyro"].in_("deg/h").std(), better["gyro"].in_("deg/h").std())
print(better["gyro.extrapolated"].values.max())

# %%
tumble.report(result, "fog.html")
