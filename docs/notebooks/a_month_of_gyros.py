# %% [markdown]
# # A month of gyros: one plan, many units
#
# Use this notebook when you test many units by one plan. You need their recordings. You get a table with a row for each
# unit, and what the units have in common: spread, chart, units that do not belong to the others, capability and risks.
#
# Sixty simulated gyros take the place of a month of production: their angle random walks differ by 5 %, number 41 has
# twice as much, and the file of number 17 is damaged.

# %%
import pathlib

import matplotlib.pyplot as plt
import numpy as np

import tumble
from tumble import fleet

production = pathlib.Path("production")
production.mkdir()
rng = np.random.default_rng(1)
for number in range(60):
    walk = 0.02 * (2.0 if number == 41 else rng.normal(1.0, 0.05))
    rate = rng.normal(0.3, 0.01) + rng.normal(0.0, walk, 30_000)
    gyro = tumble.from_arrays({"gyro.x": (rate, "deg/s")}, rate=100)
    gyro.save(production / f"SN{number:03}.h5")
damaged = production / "SN017.h5"
_ = damaged.write_bytes(damaged.read_bytes()[:5000])

# %% [markdown]
# Two processes reduce them. The same command again computes only what is new; a run that was interrupted goes on.

# %%
units = fleet.run("allan_noise", production, "month", workers=2)
units

# %%
units.errors()

# %% [markdown]
# The table has a row for each recording, in the order of their names. It does not depend on who computed what when.

# %%
table = units.table().to_pandas()
name = "gyro.x.angle_random_walk"
table[["serial", "status", name, f"{name}_sd"]].head()

# %% [markdown]
# When, where and how long: the log.

# %%
log = units.log().to_pandas()
log.loc[log["status"].notna(), ["recording", "process", "processor_seconds"]].head(3)

# %% [markdown]
# What the units have in common. With a limit the summary has the capability and the risks of decision rules; the last
# rule is the guard band that follows from this fleet.

# %%
limits = {name: (None, "0.14 deg/sqrt(h)")}
summary = units.summary([name], limits=limits)
summary

# %%
summary.tables[f"{name} outliers"].to_pandas()

# %%
summary.tables[f"{name} risk"].to_pandas()

# %% [markdown]
# The distribution of the results beside that of the true values, from which the scatter of the measurement was removed.

# %%
figure, axes = plt.subplots()
for curve in summary.curves:
    if curve.figure == f"{name}, distribution":
        axes.plot(curve.x.values, curve.y.values, label=curve.name)
        axes.set_xlabel(f"{curve.x.name} [{curve.x.unit}]")
axes.legend()
plt.show()

# %% [markdown]
# The report has all of it on one page that needs no network: distributions, charts, components, capability and risks.

# %%
units.report("month.html", parameters=[name], limits=limits)

# %% [markdown]
# Next month the folder grows. After many runs `compact` makes one Parquet file of each model and month; pandas, polars,
# DuckDB and Spark read them.

# %%
units.compact()
