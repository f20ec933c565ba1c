# %% [markdown]
# # From a ROS bag to Kalibr's imu.yaml
#
# Use this notebook when Kalibr, or a program that reads its files, needs the noise of your IMU. You need a bag of several hours
# at rest, with `sensor_msgs/Imu`. You get `imu.yaml` with densities that follow from the data, and you see how well they are
# known. `pip install 'tumble[import]'` brings the reader of bags.
#
# Here the bag is made from a simulated IMU, so that the truth is known.

# %%
import warnings
from pathlib import Path

import numpy as np
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

import tumble

warnings.simplefilter("ignore", tumble.TumbleWarning)
plan = tumble.load_plan("plans/imu_at_rest.toml")
truth = tumble.simulate(plan, seed=4)

# %%
store = get_typestore(Stores.ROS1_NOETIC)
types = store.types


def imu_message(nanoseconds, gyro, accelerometer):
    stamp = types["builtin_interfaces/msg/Time"](sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
    header = types["std_msgs/msg/Header"](seq=0, stamp=stamp, frame_id="imu")
    unknown = np.zeros(9)
    upright = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    vector = types["geometry_msgs/msg/Vector3"]
    rate, force = vector(*gyro), vector(*accelerometer)
    return types["sensor_msgs/msg/Imu"](header, upright, unknown, rate, unknown, force, unknown)


gyros = np.column_stack([truth[f"gyro_{axis}"].values for axis in "xyz"])
forces = np.column_stack([truth[f"accelerometer_{axis}"].values for axis in "xyz"])
Path("imu.bag").unlink(missing_ok=True)
with Writer("imu.bag") as bag:
    connection = bag.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=store)
    for k in range(0, 60_000):  # ten minutes; take hours for bias random walk
        time = 1_700_000_000_000_000_000 + k * 10_000_000
        raw = store.serialize_ros1(imu_message(time, gyros[k].tolist(), forces[k].tolist()), "sensor_msgs/msg/Imu")
        bag.write(connection, time, bytes(raw))

# %%
imu = tumble.read("imu.bag")
imu

# %%
result = tumble.identify("allan_noise", imu)
densities = result.tables["densities"].to_pandas()
densities

# %% [markdown]
# Kalibr wants one value for the three axes, and none of them may be zero. Where a random walk is not significant the table shows its
# upper limit with `<`: the record is too short for a value, and `tumble.export` asks for one. Here the limit is taken.

# %%
settings = {"axes": "max", "rostopic": "/imu"}
for key, name in {"gyroscope_random_walk": "gyro_walk", "accelerometer_random_walk": "accelerometer_walk"}.items():
    rows = densities.loc[densities["key"] == key]
    texts = rows["value"].astype(str)
    if texts.str.startswith("<").all():
        limit = max(float(text.removeprefix("<")) for text in texts)
        settings[name] = f"{limit:g} {rows['unit'].iloc[0]}"
text = tumble.export(result, "kalibr", settings=settings)
Path("imu.yaml").write_text(text)
print(text)
