# %% [markdown]
# # Rehearse a turntable test
#
# Use this notebook before you book the table. You need a plan: instrument, table, schedule, and what you expect the instrument to be.
# You get the uncertainty of every parameter before the test, a simulated test, and what another setting would change.

# %%
import warnings

import tumble

warnings.simplefilter("ignore", tumble.TumbleWarning)
plan = tumble.load_plan("plans/imu_turntable_short.toml")
before = tumble.predict(plan)
before.parameters["gyro_x_scale_factor_error"], before.parameters["gyro_x_bias"]

# %% [markdown]
# What limits a parameter? The budget says it.

# %%
for source, line in before.budget.items():
    if line["gyro_x_bias"] > 0.0:
        print(f"{source:40} {line['gyro_x_bias']:.3g} {before.parameters['gyro_x_bias'].unit}")

# %% [markdown]
# Run the test in simulation and identify. The differences from the truth should agree with the predicted uncertainties.

# %%
result = tumble.identify(plan, tumble.simulate(plan, seed=5))
for name in list(before.parameters)[:9]:
    true, found = before.parameters[name], result.parameters[name]
    print(f"{name:36} predicted sd {true.sd:9.3g}  found {(found.value - true.value) / found.sd:5.2f} sd from the truth")

# %% [markdown]
# What would half the settling time give? Change the plan and predict again: no file is edited.

# %%
faster = tumble.predict(plan.with_(settling="15 s"))
for name in ("gyro_x_bias", "gyro_x_scale_factor_error"):
    print(name, before.parameters[name].sd, faster.parameters[name].sd, before.parameters[name].unit)
