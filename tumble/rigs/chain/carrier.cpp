#include "tumble/rigs/chain/carrier.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "tumble/earth/earth.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::chain {
namespace {

using Kind = Motion::Kind;

constexpr const char* mounts[] = {"mount_roll", "mount_pitch", "mount_yaw"};

const char* word(Kind kind) {
  switch (kind) {
    case Kind::hold:
      return "hold";
    case Kind::rate:
      return "rate";
    case Kind::slew:
      return "slew";
    case Kind::sine:
      return "sine";
    case Kind::sweep:
      return "sweep";
    case Kind::random:
      return "random";
    case Kind::ramp:
      return "ramp";
    case Kind::dwell:
      return "dwell";
  }
  return "";
}

bool finite(const Motion& m) {
  return std::isfinite(m.value) && std::isfinite(m.to) && std::isfinite(m.amplitude) && std::isfinite(m.frequency) &&
         std::isfinite(m.to_frequency) && std::isfinite(m.phase);
}

}  // namespace

double ErrorValues::operator()(std::string_view name, std::size_t segment) const {
  assert(std::ranges::find(list_, name, &RigError::name) != list_.end());
  return where_present(name, segment);
}

double ErrorValues::where_present(std::string_view name, std::size_t segment) const {
  const auto found = std::ranges::find(list_, name, &RigError::name);
  if (values_.empty() || found == list_.end()) return 0.0;
  const auto row = static_cast<std::size_t>(found - list_.begin());
  return values_(row, std::min(segment, values_.columns - 1));
}

std::vector<Imperfection> joined(std::vector<std::vector<Imperfection>> lists) {
  std::vector<Imperfection> all;
  for (auto& list : lists)
    for (auto& imperfection : list) all.push_back(std::move(imperfection));
  return all;
}

std::vector<Imperfection> base_imperfections() {
  return {{quantity("level_sd", "arcsec")
               .at_least(0)
               .otherwise("2 arcsec")
               .says("level of the base, about east and about north"),
           {error_names::level_about_east, error_names::level_about_north}},
          {quantity("azimuth_sd", "arcsec").at_least(0).otherwise("10 arcsec").says("azimuth of the base"),
           {error_names::azimuth}},
          gravity_imperfection()};
}

Imperfection gravity_imperfection() {
  return {quantity("gravity_sd", "ug")
              .at_least(0)
              .says("gravity at the rig; absent: 5 ug where [site] states gravity as measured, else that of the "
                    "normal gravity formula"),
          {error_names::gravity}};
}

std::vector<Imperfection> lever_imperfections(const char* sd) {
  return {{quantity("lever_sd", "mm").at_least(0).otherwise(sd).says("each of lever_x, lever_y, lever_z"),
           {error_names::lever_x, error_names::lever_y, error_names::lever_z}}};
}

std::vector<Imperfection> mount_imperfections() {
  return {{quantity("mount_sd", "arcsec")
               .at_least(0)
               .otherwise("20 arcsec")
               .says("error of the instrument on the fixture, about each of its axes"),
           {error_names::mounting_x, error_names::mounting_y, error_names::mounting_z}}};
}

std::vector<RigError> errors_of(const std::vector<Imperfection>& imperfections, const Settings& options,
                                const std::optional<Site>& site) {
  const bool ideal = options.flag("ideal");
  std::vector<RigError> errors;
  for (const auto& imperfection : imperfections)
    for (const auto& name : imperfection.errors) {
      const std::string& option = imperfection.option.name;
      const bool is_gravity = name == error_names::gravity;
      const double sd = is_gravity && !options.has(option) ? gravity_sd(site) : options.number(option);
      errors.push_back({name, ideal ? 0.0 : sd, imperfection.each_segment});
      if (is_gravity) errors.push_back({error_names::latitude, ideal || !site ? 0.0 : latitude_sd(*site)});
    }
  return errors;
}

std::vector<Option> lever_options(const char* x, const char* y, const char* z) {
  return {quantity("lever_x", "mm").otherwise(x).says("position of the instrument's reference point, along x"),
          quantity("lever_y", "mm").otherwise(y).says("along y"),
          quantity("lever_z", "mm").otherwise(z).says("along z")};
}

std::vector<Option> laboratory_options() {
  return {quantity("temperature", "degC")
              .above(-273.15)
              .otherwise("20 degC")
              .says("temperature of the laboratory and the instrument"),
          flag("ideal").says("true: the rig has no errors, and its sensors have no noise")};
}

std::vector<Axis> mount_axes() {
  return {
      {mounts[0], "deg", {Kind::hold}, "turn of the instrument on the fixture about its x axis, after pitch and yaw"},
      {mounts[1], "deg", {Kind::hold}, "about its y axis, after yaw"},
      {mounts[2], "deg", {Kind::hold}, "about the fixture's z axis, first"}};
}

Kinematics ground_of(const std::optional<Site>& site, double gravity_error, double latitude_error) {
  const double upwards = (site ? gravity(*site) : standard_gravity) + gravity_error;
  if (!site) return {{}, {}, {0.0, 0.0, upwards}};
  Site true_site = *site;
  true_site.latitude += latitude_error;
  return {earth_rate_in_level(true_site), {}, {0.0, 0.0, upwards}};
}

Rotation base_from_level(const ErrorValues& errors) {
  return about_x(errors(error_names::level_about_east)) * about_y(errors(error_names::level_about_north)) *
         about_z(errors(error_names::azimuth));
}

std::vector<Pose> poses_of(const Schedule& run, const ErrorValues& errors) {
  const auto mounting = [&](const char* name) { return errors.where_present(name); };  // by hand there is no fixture
  const Rotation misalignment = about_x(mounting(error_names::mounting_x)) *
                                about_y(mounting(error_names::mounting_y)) * about_z(mounting(error_names::mounting_z));
  std::vector<Pose> poses;
  double angles[3] = {0.0, 0.0, 0.0}, begin = 0.0;
  for (const auto& segment : run) {
    bool changed = poses.empty();
    for (int i = 0; i < 3; ++i) {
      const auto found = segment.axes.find(mounts[i]);
      if (found == segment.axes.end() || found->second.value == angles[i]) continue;
      angles[i] = found->second.value;
      changed = true;
    }
    if (changed) poses.push_back({begin, misalignment * about_x(angles[0]) * about_y(angles[1]) * about_z(angles[2])});
    begin += segment.duration;
  }
  if (poses.empty()) poses.push_back({0.0, misalignment});
  return poses;
}

std::function<std::size_t(double)> segment_at(const Schedule& run) {
  std::vector<double> ends;
  double end = 0.0;
  for (const auto& segment : run) ends.push_back(end += segment.duration);
  return [ends](double time) {
    const auto after = std::upper_bound(ends.begin(), ends.end(), time);
    return std::min(static_cast<std::size_t>(after - ends.begin()), ends.size() - 1);
  };
}

std::function<double(double)> last_value(const Schedule& run, const std::string& axis) {
  std::vector<double> values;
  double value = 0.0;
  for (const auto& segment : run) {
    if (const auto found = segment.axes.find(axis); found != segment.axes.end()) value = found->second.value;
    values.push_back(value);
  }
  return [values, at = segment_at(run)](double time) { return values[at(time)]; };
}

void check_order(const Settings& options, const std::string& lowest, const std::string& highest, Problems& problems) {
  if (!(options.number(lowest) < options.number(highest)))
    problems.push_back(say("[rig] {} must lie below {}", Name{lowest}, Name{highest}));
}

bool check_axes(const std::vector<Axis>& axes, const Schedule& schedule, Problems& problems) {
  const std::size_t before = problems.size();
  std::vector<std::string> known;
  for (const auto& axis : axes) known.push_back(axis.name);
  for (const auto& segment : schedule) {
    for (const auto& [name, motion] : segment.axes) {
      const auto axis = std::find_if(axes.begin(), axes.end(), [&](const Axis& a) { return a.name == name; });
      if (axis == axes.end()) {
        problems.push_back(within(place_of_segment(segment.label),
                                  say("there is no axis '{}'; the rig has {}", name, fmt::join(known, ", "))));
        continue;
      }
      std::vector<std::string> words;
      for (const auto kind : axis->motions) words.emplace_back(word(kind));
      if (std::find(axis->motions.begin(), axis->motions.end(), motion.kind) == axis->motions.end())
        problems.push_back(within(place_of_segment(segment.label), say("{} cannot {}: this axis accepts {}", Name{name},
                                                                       word(motion.kind), fmt::join(words, ", "))));
      else if (!finite(motion))
        problems.push_back(
            within(place_of_segment(segment.label), say("the motion of {} is not a finite number", Name{name})));
    }
  }
  return problems.size() == before;
}

std::vector<Schedule> runs_of(const Schedule& schedule) {
  std::vector<Schedule> runs;
  int run = 0;
  for (const auto& segment : schedule) {
    if (runs.empty() || segment.run != run) runs.emplace_back();
    run = segment.run;
    runs.back().push_back(segment);
  }
  return runs;
}

}  // namespace tumble::chain

namespace tumble {

bool is_mount_axis(std::string_view axis) {
  return std::ranges::any_of(chain::mounts, [axis](const char* mount) { return mount == axis; });
}

}  // namespace tumble
