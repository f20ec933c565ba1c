// An export of one's own: a calibration as lines "name = numbers" for the firmware of a small board.

#include <fmt/format.h>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"

namespace tumble::exports::my_export {
namespace {

using namespace writing;

std::vector<std::string> carries() { return terms_ending({"bias", "scale_factor", "misalignment"}); }

std::vector<Option> options() {
  return {text("board").otherwise("board").says("name of the board, the first word of each line")};
}

/// y = b + K u, so that u = M (y - b) with M the inverse of K.
std::string lines_of(const TriadCalibration& triad, const std::string& name) {
  const Matrix3 m = inverse(triad.response);
  return fmt::format("{}.bias = {}\n{}.matrix = {}\n", name, row(triad.bias), name, matlab(m));
}

std::string write(const ImuCalibration& calibration, const Settings& settings, const std::vector<std::string>& header) {
  require_calibration(calibration, "my_export");
  const std::string board = settings.word("board");
  std::string file = commented(header, "#");
  if (calibration.gyros.calibrated) file += lines_of(calibration.gyros, board + ".gyro");
  if (calibration.accelerometers.calibrated) file += lines_of(calibration.accelerometers, board + ".accelerometer");
  return file;
}

}  // namespace

extern const Export my_export{.name = "my_export",
                              .summary = "firmware of a small board: biases and matrices, a line each",
                              .formula = "corrected = matrix (raw - bias)",
                              .units = "rad/s, m/s^2",
                              .frame = "axes of the calibration",
                              .source = "examples/adding/my_export.cpp",
                              .comment = "#",
                              .extension = ".txt",
                              .carries = carries,
                              .estimates = no_terms,
                              .takes_counts = false,
                              .options = options,
                              .write = write};

}  // namespace tumble::exports::my_export
