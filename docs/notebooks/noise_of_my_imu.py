# %% [markdown]
# # Noise of my IMU in five minutes
#
# Use this notebook when you have a recording of an IMU at rest and want its noise terms. You need the recording and the
# units of its columns. You get angle random walk, bias instability and the other terms with their uncertainties.

# %%
import warnings

import matplotlib.pyplot as plt

import tumble

warnings.simplefilter("ignore", tumble.TumbleWarning)  # findings are shown below
imu = tumble.read("examples/data/mpu6050_static.csv")
imu

# %% [markdown]
# The checks look for gaps, outliers, stuck outputs and the like. An info needs no action.

# %%
for finding in imu.check():
    print(finding)

# %%
result = tumble.identify("allan_noise", imu)
result

# %% [markdown]
# Every parameter has its value, standard uncertainty and 95 % interval, and any unit that you want.

# %%
walk = result.parameters["gyro.x.angle_random_walk"]
print(walk, walk.interval)
print(walk.in_("deg/sqrt(s)"))
print(walk.in_("rad/sqrt(s)"))

# %% [markdown]
# The curve is the overlapping Allan deviation with its 95 % band.

# %%
curve = next(one for one in result.curves if one.name == "gyro.x allan_deviation")
assert curve.lower is not None  # this curve has a band
assert curve.upper is not None
figure, axes = plt.subplots()
axes.fill_between(curve.x.values, curve.lower, curve.upper, alpha=0.3, label=curve.band)
axes.loglog(curve.x.values, curve.y.values, label=curve.name)
axes.set_xlabel(f"{curve.x.name} [{curve.x.unit}]")
axes.set_ylabel(f"{curve.y.name} [{curve.y.unit}]")
axes.legend()
plt.show()

# %% [markdown]
# How long must the record be for 5 % of each term? The table `advice` says it.

# %%
result.tables["advice"].to_pandas()

# %%
result.save("noise.html")  # the report: one page that needs no network
