#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tumble/archive/deposits/sources.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/core/finding.hpp"
#include "tumble/math/matrix.hpp"

/// Parts that charts, histories and summaries of an archive have in common.
namespace tumble::statistics {

/// Results of one unit, of one day (UTC) and with the same shared errors: their mean, weighted by the private parts of
/// their uncertainties. Results of one day are not independent of each other, so that a day counts once.
struct Occasion {
  std::size_t unit = 0;                  ///< index in ParameterOverUnits::units
  std::int64_t day = 0;                  ///< since 1970
  double moment = 0.0;                   ///< [s] since 1970, of the last result
  double value = 0.0, private_sd = 0.0;  ///< [SI]
  std::int64_t sources = 0;              ///< ChartValue::sources
  std::int64_t result = 0;               ///< number of the last result
  std::size_t results = 0;
};

/// In order of time. Values without a finite value or uncertainty are not used; `unused`, where given, is their number.
std::vector<Occasion> occasions_of(const ParameterOverUnits& over, std::size_t* unused = nullptr);

/// [s] since 1970, in order: when each unit of ParameterOverUnits::units was adjusted.
using Adjustments = std::vector<std::vector<double>>;
Adjustments adjustments_of(const Archive& archive, const ParameterOverUnits& over);

/// Removes the values of each unit from before its last adjustment; the time of the latest one that removed any.
std::string begin_at_adjustment(const Archive& archive, ParameterOverUnits& over);

/// Adds a finding where results were made from the same recordings, by the same method, as another one of the unit:
/// they are no new evidence, and count.
void note_same_recordings(const Archive& archive, const ParameterOverUnits& over, Findings& findings);

/// The first occasion of each unit, in order of time: a chart of the production.
std::vector<Occasion> first_of_each_unit(const std::vector<Occasion>& occasions, std::size_t units);

/// The shared errors of each number `sources` among the occasions, from the text of one result that has it.
using SharedBySource = std::map<std::int64_t, std::vector<deposits::KeyedError>>;
SharedBySource shared_errors(const Archive& archive, const std::string& parameter,
                             const std::vector<Occasion>& occasions);

/// Factors [n x k] [SI] of the shared errors, a row for each occasion and a column for each error.
Matrix shared_factors(const std::vector<Occasion>& occasions, const SharedBySource& errors);

/// The first day of an occasion as a date, "2026-03-01"; a moment [s] since 1970 as a time.
std::string date_of(std::int64_t day);
std::string time_of(double moment);
double moment_of_text(const std::string& time);
/// "model/serial" of a unit; SHA-256 of a result.
std::string name_of(const UnitName& unit);
std::string sha256_of_result(const Archive& archive, std::int64_t result);

/// Unit [u], followed by "/day" or another text; the unit 1 is not written.
Unit unit_by(const Unit& unit, const std::string& by);

}  // namespace tumble::statistics
