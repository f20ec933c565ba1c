#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/prior.hpp"
#include "tumble/core/read_options.hpp"
#include "tumble/core/schedule.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {

/// Where the rig stands.
struct Site {
  double latitude = 0.0;                   ///< [rad], geodetic
  double longitude = 0.0;                  ///< [rad]
  std::optional<double> height;            ///< [m] above the ellipsoid; absent: not stated, and taken as 0
  std::optional<double> gravity;           ///< [m/s^2] as measured; absent: the normal gravity formula
  std::optional<double> latitude_sd = {};  ///< [rad] standard uncertainty; absent: see earth.hpp
};

/// The channel that plays a role: `gyro = "dtg.x"`, or with the unit of a column that has none, `"dtg.x[deg/h]"`.
struct ChannelChoice {
  std::string channel;
  std::optional<Unit> unit;
};

/// A further instrument on the same fixture: it feels what the first one feels, turned as it is mounted, and its
/// channels are called "<name>.<channel>".
struct Beside {
  std::string name;
  std::string model;  ///< catalogue name in models/
  Settings truth;     ///< resolved against the model's options
  /// Angles from the axes of the first instrument to those of this one: about x (roll), about y (pitch), about z (yaw)
  /// [rad], z first.
  double mount_roll = 0.0, mount_pitch = 0.0, mount_yaw = 0.0;
};

struct Estimate;
struct Plan;

/// The result of an earlier test of the same instrument, on which a method may build.
struct Calibration {
  std::string file;                                  ///< resolved; empty: none
  std::string sha256;                                ///< of its bytes
  std::shared_ptr<const Estimate> result = nullptr;  ///< null until it is read
};

/// A file that belongs to the test.
struct RecordingEntry {
  std::string file;                       ///< resolved against the plan's folder
  std::string segment;                    ///< label of the schedule's segment it holds; empty: the whole schedule
  int run = 0;                            ///< which power-up; 0: as the schedule or the file says
  std::shared_ptr<const Plan> plan = {};  ///< its own rig, site and schedule; null: those of the plan that names it
  std::vector<std::string> columns = {};  ///< of a text file: name[unit] of each, in place of its header
  std::string segment_column = {};        ///< of a text file: holds the labels of the segments
  std::string frames = {};                ///< of raw bytes: the declaration of their frames, by name or file
  std::vector<std::string> topics = {};   ///< of a log with several streams: those wanted; empty: as its format chooses
  char decimal = '\0';                    ///< of a text file: its decimal mark; 0: as the samples show it
  std::string time = {}, date = {}, encoding = {};  ///< of a text file: as in ReadOptions
  std::size_t skip = 0;                             ///< of a text file: lines before the header
};

/// A limit on a parameter. The bounds are as written; the unit is checked against the parameter when judged.
struct Limit {
  std::string parameter;
  std::optional<Quantity> min, max;
  std::string where;
};

/// A test: which instrument is on which rig, how the rig moves, and which method reduces the data.
struct Plan {
  std::string file;                                      ///< empty: no file (`tumble identify allan_noise data.csv`)
  std::string sha256 = {};                               ///< of the bytes of the file
  std::optional<std::string> text = {};                  ///< of the file, up to 100 kB
  std::map<std::string, std::string> command_line = {};  ///< the values of `--set`, by key
  std::string title;
  std::string method;
  std::string instrument_model;  ///< catalogue name in models/, may be empty
  std::string instrument_serial;
  double sample_rate = 0.0;  ///< [Hz], for simulation
  std::optional<Site> site;
  std::string rig_kind;            ///< catalogue name in rigs/, may be empty
  Settings rig;                    ///< resolved against the rig's options
  std::string rig_equipment = {};  ///< serial and certificate number of the rig, may be empty: key of its errors
  Schedule schedule;               ///< in order of time: sorted by run
  std::map<std::string, std::vector<ChannelChoice>> channels;  ///< by role: one, or several where the role takes them
  std::vector<RecordingEntry> recordings;
  ReadOptions reading = {};  ///< what the command line says of the files; goes before what the plan says of them
  Calibration calibration = {};
  PriorChoice prior = {};
  Settings settings;  ///< resolved against the method's options
  std::vector<Limit> limits;
  Settings truth;              ///< resolved against the model's options, for simulate and predict
  std::vector<Beside> beside;  ///< further instruments, to be simulated
};

}  // namespace tumble
