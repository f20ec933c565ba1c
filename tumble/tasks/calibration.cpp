#include "tumble/tasks/calibration.hpp"

#include <fmt/format.h>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// The same instrument as far as both say which one they are of.
void refuse_other_instrument(const Plan& plan, const Estimate& result) {
  const auto& file = plan.calibration.file;
  if (!result.instrument_serial.empty() && !plan.instrument_serial.empty() &&
      result.instrument_serial != plan.instrument_serial)
    throw Error(Error::Kind::bad_input,
                say("{}: the calibration {} is of the instrument with serial '{}', the plan's has '{}'",
                    Name{plan.file}, Name{file}, result.instrument_serial, plan.instrument_serial));
}

}  // namespace

void read_calibration(Plan& plan) {
  auto& calibration = plan.calibration;
  if (calibration.file.empty() || calibration.result) return;
  Estimate result;
  try {
    const auto text = read_text_file(calibration.file);
    result = estimate_from_json(text, calibration.file);
    calibration.sha256 = sha256_of(text);
  } catch (const Error& error) {
    auto problems = error.problems;
    const std::string where = plan.file.empty() ? "--set calibration" : plan.file;
    for (auto& problem : problems)
      problem = within(
          Where{.file = plan.file,
                .place = say("{}: the calibration must be a result that `tumble identify -o` wrote", Name{where})},
          problem);
    throw Error(error.kind, problems);
  }
  refuse_other_instrument(plan, result);
  calibration.result = std::make_shared<const Estimate>(std::move(result));
}

}  // namespace tumble
