#include "tumble/reduce/linear/courses.hpp"

#include <algorithm>
#include <set>
#include <span>

#include "tumble/math/golden_section.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble::linear {
namespace {

/// Instants of a row in which the rig moves, and of one over many turns, so spaced that they fall in step with none.
constexpr std::size_t instants_of_motion = 8, instants_of_turns = 64;
constexpr double part_of_slope = 0.05;  ///< [1] of a row, over which its slope at either end is taken

/// The instrument of one output, with its power-up.
struct Shower {
  const PowerUp& power_up;
  const Problem& problem;
  const std::vector<double>& coefficients;

  double operator()(const Felt& felt) const {
    double value = problem.input ? problem.input(felt) : 0.0;
    for (std::size_t j = 0; j < coefficients.size(); ++j)
      if (coefficients[j] != 0.0) value += coefficients[j] * problem.columns[j].regressor(felt);
    return value;
  }
  double at_time(double time, double step) const {
    Felt felt;
    power_up.reference.felt(time, step, std::span(&felt, 1));
    return (*this)(felt);
  }
};

/// The begin and the length of a row [s since power-on].
struct RowLength {
  double begin = 0.0, length = 0.0;
};

RowLength length_of(const Stretch& stretch, const Blocking& blocking, std::size_t block) {
  const std::size_t begin = block * blocking.per_block, size = std::min(blocking.per_block, stretch.samples - begin);
  return {stretch.first + static_cast<double>(begin) * stretch.step, static_cast<double>(size) * stretch.step};
}

/// Slope and bend of a moving output from its values next to the ends of the row.
void add_slopes(const Shower& shown, const RowLength& row, double step, Course& course) {
  const double part = part_of_slope * row.length, end = row.begin + row.length;
  const double first = shown.at_time(row.begin, step), second = shown.at_time(row.begin + part, step);
  // a point at the very end may belong to the next segment
  const double last = shown.at_time(end - part, step), before = shown.at_time(end - 2.0 * part, step);
  course.slope = (last - first) / (row.length - part);
  course.bend = ((last - before) - (second - first)) / part / (row.length - 2.0 * part);
}

std::vector<double> instants_in(const RowLength& row, const Blocking& blocking, bool steady) {
  if (steady) return {row.begin + 0.5 * row.length};
  std::vector<double> times(blocking.even ? instants_of_turns : instants_of_motion);
  const double count = static_cast<double>(times.size());
  for (std::size_t k = 0; k < times.size(); ++k)
    times[k] = row.begin +
               row.length * (blocking.even ? golden_fraction(k, 0.5 / count) : (static_cast<double>(k) + 0.5) / count);
  return times;
}

std::vector<double> angles_at(const PowerUp& power_up, const std::string& axis, const std::vector<double>& times) {
  std::vector<double> angles(times.size(), 0.0);
  const auto drive = std::ranges::find(power_up.reference.drives, axis, &Drive::axis);
  for (std::size_t k = 0; k < times.size() && drive != power_up.reference.drives.end(); ++k)
    angles[k] = drive->at(times[k]).value;
  return angles;
}

}  // namespace

std::vector<std::string> turning_axes(const ConductedTest& test) {
  std::vector<std::string> names;
  std::set<const Plan*> seen;
  for (const PowerUp& power_up : test.power_ups) {
    if (!power_up.plan || power_up.plan->rig_kind.empty() || !seen.insert(power_up.plan).second) continue;
    for (const Axis& axis : find_rig(power_up.plan->rig_kind).axes())
      if (axis.unit == "deg" && !is_mount_axis(axis.name) && std::ranges::find(names, axis.name) == names.end())
        names.push_back(axis.name);
  }
  return names;
}

std::vector<Course> output_courses(const Evidences& evidence, const Problem& problem, const Rows& rows,
                                   const std::vector<double>& coefficients, const std::vector<std::string>& axes) {
  std::vector<Course> courses;
  for (std::size_t row = 0; row < rows.segment.size(); ++row) {
    const std::size_t g = rows.segment[row];
    const Stretch& stretch = evidence.test.stretches[g];
    const Blocking& blocking = evidence.blocking[g];
    const PowerUp& power_up = evidence.test.power_ups[stretch.power_up];
    const Shower shown{power_up, problem, coefficients};
    const RowLength length = length_of(stretch, blocking, rows.block[row]);
    Course course{.time = power_up.offset + rows.time[row], .segment = g};
    const bool whole = !blocking.instants.empty();
    const auto times = whole ? blocking.instants.time : instants_in(length, blocking, stretch.steady);
    course.share =
        whole ? blocking.instants.share : std::vector<double>(times.size(), 1.0 / static_cast<double>(times.size()));
    for (const double time : times) course.output.push_back(shown.at_time(time, stretch.step));
    if (!evidence.uniform(g) && !whole) add_slopes(shown, length, stretch.step, course);
    for (const auto& axis : axes) course.angles.push_back(angles_at(power_up, axis, times));
    courses.push_back(std::move(course));
  }
  return courses;
}

}  // namespace tumble::linear
