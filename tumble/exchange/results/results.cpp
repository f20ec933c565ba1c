#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/certificate.hpp"
#include "tumble/exchange/results/reader.hpp"
#include "tumble/exchange/test_days.hpp"
#include "tumble/units/error.hpp"

namespace tumble::results {

std::optional<double> Reader::find(const std::string& name) {
  const Parameter* parameter = find_parameter(input_.estimate, name);
  if (!parameter) return {};
  if (!std::isfinite(parameter->value)) problem(say("the parameter '{}' has no value", name));
  return parameter->value;
}

std::string Reader::setting(const std::string& name) const {
  const auto& settings = input_.estimate.provenance.settings;
  const auto match = settings.find(name);
  return match == settings.end() ? "" : match->second;
}

double Reader::cell(const Table& table, std::size_t row, std::size_t column) {
  const auto& cells = table.rows.at(row);
  const double* number = column < cells.size() ? std::get_if<double>(&cells[column]) : nullptr;
  if (number && std::isfinite(*number)) return *number;
  problem(say("the table {} lacks a number in row {}", table.name, row + 1));
  return 0.0;
}

void Reader::claim(const std::string& what, std::set<std::string>& claimed) {
  if (!claimed.insert(what).second) problem(say("another result states {} as well: name one of them", what));
}

std::string role(bool gyro, std::size_t axis) { return std::string(gyro ? "gyro_" : "accelerometer_") + "xyz"[axis]; }

TriadCalibration& triad(ImuCalibration& calibration, bool gyro) {
  return gyro ? calibration.gyros : calibration.accelerometers;
}

Unit si_unit(const Unit& unit) { return Unit::parse(name(unit.dimension())); }

Unit input_unit(bool gyro) { return Unit::parse(gyro ? "rad/s" : "m/s^2"); }

namespace {

struct MethodReader {
  const char* method;
  void (*read)(Reader&, std::set<std::string>&);
  bool single;
};

constexpr MethodReader readers[] = {
    {"imu_turntable", read_terms, false},           {"imu_multi_position", read_terms, false},
    {"imu_ferraris", read_ferraris, false},         {"imu_channel_calibration", read_channels, false},
    {"accelerometer_tumble", read_tumble, true},    {"accelerometer_four_position", read_four_position, true},
    {"gyro_scale_factor", read_scale_factor, true}, {"static_bias", read_static_bias, true},
    {"fog_thermal_bias", read_fog, true},           {"allan_noise", read_noise, false}};

void read(Reader& reader, std::set<std::string>& claimed) {
  const Estimate& estimate = reader.estimate();
  const auto* entry = std::ranges::find_if(readers, [&](const auto& r) { return estimate.method == r.method; });
  if (entry == std::end(readers)) {
    std::vector<std::string_view> known;
    for (const auto& one : readers) known.emplace_back(one.method);
    return reader.problem(say("a result of {} holds no calibration of an inertial unit; these do: {}", estimate.method,
                              fmt::join(known, ", ")));
  }
  if (!reader.input().axis.empty() && !entry->single)
    return reader.problem(
        say("a result of {} names its axes itself: write the file without {}=", estimate.method, reader.input().axis));
  entry->read(reader, claimed);
}

/// Title, model and serial: of the first result that has them; a serial that differs is a problem.
void set_identity(Reader& reader) {
  const Estimate& e = reader.estimate();
  ImuCalibration& c = reader.calibration();
  if (c.title.empty()) c.title = e.title;
  if (c.model.empty()) c.model = e.instrument_model;
  if (c.serial.empty()) c.serial = e.instrument_serial;
  if (!e.instrument_serial.empty() && e.instrument_serial != c.serial && reader.input().axis.empty())
    reader.note(fmt::format("results of several serial numbers: {} and {} ({})", c.serial, e.instrument_serial,
                            reader.input().file));
}

ParameterBlock block_of(const Estimate& estimate) {
  ParameterBlock block;
  for (const auto& parameter : estimate.parameters) {
    block.names.push_back(parameter.name);
    block.units.push_back(parameter.unit);
    block.values.push_back(parameter.value);
  }
  block.covariance = estimate.covariance;
  return block;
}

/// A matrix that is not invertible calibrates nothing.
void check_response(const TriadCalibration& triad, const char* what, Problems& problems) {
  const Matrix3& k = triad.response;
  const double size = norm(k.x) * norm(k.y) * norm(k.z);
  if (!(std::abs(determinant(k)) > 1e-6 * size))
    problems.push_back(say("the {} of the result do not show three directions: their matrix cannot be inverted", what));
}

/// Axes that no result is of: outputs in counts are taken to be as large as those of the axes that are calibrated.
void fill_other_axes(TriadCalibration& triad, bool gyro) {
  if (!triad.calibrated || triad.output.dimension() == input_unit(gyro).dimension()) return;
  double size = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    if (triad.axes[i]) size = std::max(size, std::abs(triad.response(i, i)));
  for (std::size_t i = 0; i < 3; ++i)
    if (!triad.axes[i]) triad.response(i, i) = size;
}

/// "2026-11-01 to 2026-11-03"; empty unless each result says its days.
std::string date_of(const std::vector<CalibrationInput>& inputs) {
  std::optional<TestDays> all;
  for (const auto& input : inputs) {
    const auto days = test_days(input.estimate);
    if (!days) return "";
    all = all ? TestDays{std::min(all->begun, days->begun), std::max(all->ended, days->ended)} : *days;
  }
  if (!all) return "";
  return iso_date(all->begun) + (all->begun == all->ended ? "" : " to " + iso_date(all->ended));
}

}  // namespace
}  // namespace tumble::results

namespace tumble {

ImuCalibration calibration_of(const std::vector<CalibrationInput>& inputs) {
  if (inputs.empty()) throw Error(Error::Kind::bad_input, "there is no result to make a calibration from");
  ImuCalibration calibration;
  calibration.date = results::date_of(inputs);
  Problems problems;
  std::set<std::string> claimed;
  for (const auto& input : inputs) {
    results::Reader reader(input, calibration, problems);
    results::read(reader, claimed);
    results::set_identity(reader);
    calibration.sources.push_back({input.file, input.sha256, input.estimate.method, input.estimate.title});
    calibration.parameters.push_back(results::block_of(input.estimate));
  }
  if (calibration.coldest > calibration.hottest)
    problems.push_back(
        say("no temperature is covered by all results: the highest of their lowest is {:.1f} "
            "degC, the lowest of their highest {:.1f} degC; export them one by one",
            Unit::parse("degC").from_si(calibration.coldest), Unit::parse("degC").from_si(calibration.hottest)));
  results::fill_other_axes(calibration.accelerometers, false);
  results::fill_other_axes(calibration.gyros, true);
  results::check_response(calibration.accelerometers, "accelerometers", problems);
  results::check_response(calibration.gyros, "gyros", problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return calibration;
}

}  // namespace tumble
