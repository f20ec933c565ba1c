#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/assembly/reader.hpp"
#include "tumble/exchange/certificate.hpp"
#include "tumble/exchange/test_days.hpp"
#include "tumble/units/error.hpp"

namespace tumble::assembly {

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

void Reader::claim(const std::string& what, std::set<std::string>& claimed) {
  if (!claimed.insert(what).second) problem(say("another result states {} as well: name one of them", Name{what}));
}

std::string role(bool gyro, std::size_t axis) { return std::string(gyro ? "gyro_" : "accelerometer_") + "xyz"[axis]; }

TriadCalibration& triad(ImuCalibration& calibration, bool gyro) {
  return gyro ? calibration.gyros : calibration.accelerometers;
}

Unit si_unit(const Unit& unit) { return Unit::parse(name(unit.dimension())); }

Unit input_unit(bool gyro) { return Unit::parse(gyro ? "rad/s" : "m/s^2"); }

namespace {

void read(Reader& reader, std::set<std::string>& claimed) {
  const Estimate& estimate = reader.estimate();
  if (!reader.input().axis.empty() && estimate.models.size() != 1)
    return reader.problem(say("a result of {} names its axes itself: write the file without {}=", Name{estimate.method},
                              Name{reader.input().axis}));
  read_models(reader, claimed);
  if (!read_noise(reader, claimed) && estimate.models.empty())
    reader.problem(say("a result of {} holds no error model and no noise of a sensor", Name{estimate.method}));
}

/// Title, model and serial: of the first result that has them; a serial that differs is a problem.
void set_identity(Reader& reader) {
  const Estimate& e = reader.estimate();
  ImuCalibration& c = reader.calibration();
  if (c.title.empty()) c.title = e.title;
  if (c.model.empty()) c.model = e.instrument_model;
  if (c.serial.empty()) c.serial = e.instrument_serial;
  if (e.provenance.seed)
    reader.note(fmt::format("specimen: the data of {} are simulated (seed {}); this calibrates no instrument",
                            reader.input().file, *e.provenance.seed));
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
}  // namespace tumble::assembly

namespace tumble {

ImuCalibration calibration_of(const std::vector<CalibrationInput>& inputs) {
  if (inputs.empty()) throw Error(Error::Kind::bad_input, "there is no result to make a calibration from");
  ImuCalibration calibration;
  calibration.date = assembly::date_of(inputs);
  Problems problems;
  std::set<std::string> claimed;
  for (const auto& input : inputs) {
    assembly::Reader reader(input, calibration, problems);
    assembly::read(reader, claimed);
    assembly::set_identity(reader);
    calibration.sources.push_back({input.file, input.sha256, input.estimate.method, input.estimate.title});
    calibration.parameters.push_back(assembly::block_of(input.estimate));
  }
  if (calibration.coldest > calibration.hottest)
    problems.push_back(
        say("no temperature is covered by all results: the highest of their lowest is {:.1f} "
            "degC, the lowest of their highest {:.1f} degC; export them one by one",
            Unit::parse("degC").from_si(calibration.coldest), Unit::parse("degC").from_si(calibration.hottest)));
  assembly::fill_other_axes(calibration.accelerometers, false);
  assembly::fill_other_axes(calibration.gyros, true);
  assembly::check_response(calibration.accelerometers, "accelerometers", problems);
  assembly::check_response(calibration.gyros, "gyros", problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return calibration;
}

}  // namespace tumble
