#include "tumble/exchange/exports/export.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/report/rounding.hpp"
#include "tumble/report/utf8.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {
namespace {

bool holds(const std::vector<std::string>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

/// Every way in which `--set` gives a noise: for all axes of a kind.
struct NoiseOption {
  const char* name;
  const char* unit;
  bool gyro;
  double AxisNoise::*value;
  const char* description;
};

constexpr NoiseOption noise_options[] = {
    {"gyro_white", "deg/sqrt(h)", true, &AxisNoise::white, "N of all gyros, in place of that of the results"},
    {"accelerometer_white", "(m/s)/sqrt(h)", false, &AxisNoise::white,
     "N of all accelerometers, in place of that of the results"},
    {"gyro_walk", "deg/h/sqrt(h)", true, &AxisNoise::walk, "K of all gyros, in place of that of the results"},
    {"accelerometer_walk", "ug/sqrt(h)", false, &AxisNoise::walk,
     "K of all accelerometers, in place of that of the results"}};

void apply(const Settings& settings, ImuCalibration& c) {
  for (const auto& option : noise_options)
    if (settings.has(option.name))
      for (auto& axis : (option.gyro ? c.gyros : c.accelerometers).noise)
        axis.*option.value = settings.number(option.name);
  if (settings.has("rate_range")) c.gyros.range = settings.number("rate_range") * Vector3{1.0, 1.0, 1.0};
  if (settings.has("force_range")) c.accelerometers.range = settings.number("force_range") * Vector3{1.0, 1.0, 1.0};
  if (settings.has("date")) c.date = settings.word("date");
  set_missing_ranges(c);
}

void inflate(ImuCalibration& c, double factor) {
  for (TriadCalibration* triad : {&c.accelerometers, &c.gyros})
    for (auto& axis : triad->noise) axis.white *= factor, axis.walk *= factor, axis.walk_limit *= factor;
}

std::string shown(double si_value, bool gyro) {
  const char* unit = gyro ? "deg/s" : "m/s^2";
  return fmt::format("{:.3g} {}", Unit::parse(unit).from_si(si_value), unit);
}

double largest(Vector3 v) { return std::max({v.x, v.y, v.z}); }

/// "0.012 m/s^2 within 9.8 m/s^2": size of the error without a term, and where.
Sentence loss(const ImuCalibration& c, const CalibrationTerm& term) {
  const Sentence text =
      say("without it the {} are off by up to {} within {} and {}", term.gyro ? "rates" : "specific forces",
          Name{shown(error_without(c, term), term.gyro)}, Name{shown(largest(c.gyros.range), true)},
          Name{shown(largest(c.accelerometers.range), false)});
  if (std::isnan(c.coldest)) return text;
  return say("{}, {:.1f} to {:.1f} degC", text, Unit::parse("degC").from_si(c.coldest),
             Unit::parse("degC").from_si(c.hottest));
}

/// "0.0117 -0.0246 0.0310 m/s^2": the bias of a triad, which the consumer estimates.
std::string values_of(const ImuCalibration& c, const CalibrationTerm& term) {
  if (!std::string_view(term.name).ends_with("_bias")) return "";
  const TriadCalibration& t = term.gyro ? c.gyros : c.accelerometers;
  return fmt::format(": {} {} {} {} at zero input", t.bias.x, t.bias.y, t.bias.z, t.output.text());
}

/// Removes what the file does not carry, and says what is dropped; what nobody allowed to drop is a problem.
std::vector<std::string> dropped_terms(const Export& entry, const std::vector<std::string>& drop, ImuCalibration& c,
                                       Problems& problems) {
  std::vector<std::string> lines;
  for (const auto& name : drop) find_calibration_term(name);
  const auto carried = entry.carries(), estimated = entry.estimates();
  const ImuCalibration whole = c;
  for (const auto& term : calibration_terms()) {
    if (!term.is_in(whole)) continue;
    if (holds(estimated, term.name) && !holds(drop, term.name)) {
      lines.push_back(
          fmt::format("not in this file, {} estimates it: {}{}", entry.name, term.name, values_of(whole, term)));
      term.remove(c);
    } else if (holds(drop, term.name)) {
      lines.push_back(fmt::format("dropped: {}; {}", term.name, loss(whole, term).text()));
      term.remove(c);
    } else if (!holds(carried, term.name)) {
      problems.push_back(say("{} cannot carry {} ({}); {}; --drop {} accepts that", entry.name, term.name,
                             term.description, loss(whole, term), term.name));
      term.remove(c);
    }
  }
  return lines;
}

void check_outputs(const Export& entry, const ImuCalibration& c, Problems& problems) {
  if (entry.takes_counts) return;
  for (const bool gyro : {false, true}) {
    const TriadCalibration& t = gyro ? c.gyros : c.accelerometers;
    const Unit wanted = Unit::parse(gyro ? "rad/s" : "m/s^2");
    if (t.calibrated && !(t.output.dimension() == wanted.dimension()))
      problems.push_back(
          say("{} reads {} in {}, but they were calibrated in {}: calibrate outputs that are "
              "converted to {}",
              entry.name, gyro ? "gyros" : "accelerometers", Name{wanted.text()}, Name{t.output.text()},
              Name{wanted.text()}));
  }
}

void add_source(const ImuCalibration& c, std::vector<std::string>& lines) {
  lines.push_back(fmt::format("title: {}", c.title.empty() ? "not stated" : c.title));
  lines.push_back(fmt::format("instrument: {}, serial number {}", c.model.empty() ? "not stated" : c.model,
                              c.serial.empty() ? "not stated" : c.serial));
  lines.push_back("date of the test: " +
                  (c.date.empty() ? "not stated in the result, nor by the setting date" : c.date));
  for (const auto& source : c.sources)
    lines.push_back(fmt::format("result: {} ({}), SHA-256 {}", source.file, source.method, source.sha256));
}

std::string noise_line(const TriadCalibration& t, const char* what, const char* white, const char* walk,
                       const char* instability) {
  const auto values = [&](double AxisNoise::*value, const char* unit) {
    std::vector<std::string> all;
    for (const auto& axis : t.noise)
      all.push_back(std::isnan(axis.*value) ? "-"
                                            : fmt::format("{:.4g}", Unit::parse(unit).difference_from_si(axis.*value)));
    return fmt::format("{} {}", fmt::join(all, " "), unit);
  };
  return fmt::format("noise of the {} x y z: N {}; K {}; B {} (B is not K and is not used as K)", what,
                     values(&AxisNoise::white, white), values(&AxisNoise::walk, walk),
                     values(&AxisNoise::instability, instability));
}

/// Which N and K the user gave, and which axes have none: their noise is not known, and not zero.
void add_noise_origin(const ImuCalibration& c, const Settings& settings, std::vector<std::string>& lines) {
  for (const auto& option : noise_options) {
    const TriadCalibration& t = option.gyro ? c.gyros : c.accelerometers;
    const char *letter = option.value == &AxisNoise::white ? "N" : "K",
               *what = option.gyro ? "gyros" : "accelerometers";
    if (settings.has(option.name)) {
      lines.push_back(fmt::format("{} of the {} is that of the setting {}, of all axes", letter, what, option.name));
      continue;
    }
    std::string without;
    for (std::size_t i = 0; i < 3; ++i)
      if (std::isnan(t.noise[i].*option.value)) without += fmt::format(" {}", "xyz"[i]);
    if (!without.empty() && without.size() < 6)  // else no axis has it
      lines.push_back(
          fmt::format("{} of the {} is not shown for{}: one number is of the other axes", letter, what, without));
  }
}

std::vector<std::string> header_of(const Export& entry, const ImuCalibration& c, const Settings& settings,
                                   const ExportRequest& request) {
  std::vector<std::string> lines{fmt::format("calibration for {}, written by tumble export", entry.name)};
  add_source(c, lines);
  lines.push_back(fmt::format("formula: {}", entry.formula));
  lines.push_back(fmt::format("units: {}", entry.units));
  lines.push_back(fmt::format("frame: {}", entry.frame));
  for (const bool gyro : {false, true}) {
    const TriadCalibration& t = gyro ? c.gyros : c.accelerometers;
    const char* what = gyro ? "gyros" : "accelerometers";
    if (!t.reading.empty()) lines.push_back(fmt::format("the {} are read as {}", what, t.reading));
    if (t.calibrated && std::ranges::count(t.axes, true) < 3)
      lines.push_back(fmt::format("of the {} only{}{}{} calibrated", what, t.axes[0] ? " x" : "", t.axes[1] ? " y" : "",
                                  t.axes[2] ? " z is" : " is"));
  }
  if (c.gyros.has_noise()) lines.push_back(noise_line(c.gyros, "gyros", "deg/sqrt(h)", "deg/h/sqrt(h)", "deg/h"));
  if (c.accelerometers.has_noise())
    lines.push_back(noise_line(c.accelerometers, "accelerometers", "(m/s)/sqrt(h)", "ug/sqrt(h)", "ug"));
  if (c.gyros.has_noise() || c.accelerometers.has_noise())
    lines.push_back(settings.word("axes") == "max" ? "one number for three axes is the greatest of them"
                                                   : "one number for three axes is their root mean square");
  add_noise_origin(c, settings, lines);
  if (request.inflate != 1.0) lines.push_back(fmt::format("N and K are multiplied by {:g}", request.inflate));
  for (const auto& note : c.notes) lines.push_back("note: " + note);
  return lines;
}

std::vector<Option> options_of(const Export& entry) {
  std::vector<Option> options = common_export_options();
  for (auto& option : entry.options()) options.push_back(std::move(option));
  return options;
}

/// A line of comment is one line, whatever a title holds, in every language of the files: YAML ends a line at U+2028 as
/// well, C++ joins the next one after a backslash and blanks, and ??/ is a backslash to C.
std::string one_line(std::string_view line) {
  std::string text = printable(line);
  for (const auto& [what, instead] : {std::pair{"*/", "* "}, {"/*", "/ "}, {"--", "- "}, {"??", "? "}})
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what)) text.replace(at, 2, instead);
  while (text.ends_with('\\') || text.ends_with(' ')) text.pop_back();
  return text;
}

}  // namespace

std::vector<Option> common_export_options() {
  std::vector<Option> options{
      word("axes", {"rms", "max"})
          .otherwise("rms")
          .says("one noise for three axes: their root mean square, or the greatest"),
      quantity("rate_range", "deg/s").above(0).says("rates for which errors are stated; default: those of the results"),
      quantity("force_range", "g")
          .above(0)
          .says("specific forces for which errors are stated; default: those of the results"),
      text("date").says("date of the test, for the header of the file; default: as the recordings say it")};
  for (const auto& option : noise_options)
    options.push_back(quantity(option.name, option.unit).above(0).says(option.description));
  return options;
}

const Export& find_export(std::string_view name) {
  std::string wanted(name);
  std::ranges::replace(wanted, '-', '_');
  std::vector<std::string> known;
  for (const Export* entry : export_catalogue()) {
    if (entry->name == wanted) return *entry;
    known.emplace_back(entry->name);
  }
  throw Error(Error::Kind::unsupported,
              say("there is no export '{}'{} (known: {})", name, did_you_mean(wanted, known), fmt::join(known, ", ")));
}

std::string export_calibration(const Export& entry, ImuCalibration calibration, const ExportRequest& request) {
  Problems problems;
  const Settings settings = resolve(options_of(entry), request.settings, say("export {}", Name{entry.name}), problems);
  if (!(request.inflate > 0.0) || !std::isfinite(request.inflate))
    problems.emplace_back("--inflate must be a number above 0");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  apply(settings, calibration);
  inflate(calibration, request.inflate);
  check_outputs(entry, calibration, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  const ImuCalibration whole = calibration;
  const auto dropped = dropped_terms(entry, request.drop, calibration, problems);
  auto header = header_of(entry, whole, settings, request);
  header.insert(header.end(), dropped.begin(), dropped.end());
  for (auto& line : header) line = one_line(line);
  try {
    std::string file = entry.write(calibration, settings, header);
    if (problems.empty()) return file;
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_input) throw;
    problems.insert(problems.end(), error.problems.begin(), error.problems.end());
  }
  throw Error(Error::Kind::bad_input, problems);
}

}  // namespace tumble
