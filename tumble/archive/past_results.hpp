#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tumble/archive/deposit.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/core/estimate.hpp"
#include "tumble/units/sentence.hpp"

/// Numbers of results that statistics take from each of them (statistics.hpp). An archive and a folder of results both
/// give it.
namespace tumble {

/// One result, with the numbers that an archive gives it: both make the same answers.
struct SummarisedResult {
  std::string file, sha256;
  std::int64_t number = 0;  ///< from the SHA-256
  UnitName unit;
  double moment = 0.0;     ///< [s] since 1970
  std::string recordings;  ///< method and SHA-256 of each recording, a line for each; empty: none is known
  struct Value {
    std::string parameter, shown;  ///< name, and the unit that people are shown
    double value = 0.0, sd = 0.0;  ///< [SI]
    double private_sd = 0.0;       ///< [SI], of the errors that no other result shares
    std::int64_t sources = 0;      ///< ChartValue::sources
  };
  std::vector<Value> values;
};

/// Summary of a result. Adds to `problems` what is wrong with it, as put_in() reports it.
///
/// Given     undated  UTC, the time of a result whose recordings have none
SummarisedResult summary_of_result(const ResultDeposit& deposit, const std::string& undated, Problems& problems);

/// How statistics read what they need of few results only. Results are named by ChartValue::result.
struct ResultReader {
  std::function<Estimate(std::int64_t)> estimate;
  std::function<std::string(std::int64_t)> sha256;
  std::function<std::string(std::int64_t)> recordings;  ///< SummarisedResult::recordings
};

/// The values of a parameter over units and time. Throws as its functions: Error::bad_file.
struct PastResults {
  ParameterOverUnits over;
  std::vector<std::vector<double>> adjusted;  ///< [s] since 1970, in order, for each of over.units; empty: never
  ResultReader read;
};

/// Values of results that are in no archive. The reader reads their files again, so `results` must live as long.
/// Throws Error::bad_input where no result of the model has the parameter, or units differ in dimension.
PastResults past_results(const std::vector<SummarisedResult>& results, const std::string& parameter,
                         const std::string& model);

/// Values of an archive, which must live as long. Throws as parameter_over_units().
///
/// Given     with_adjustments  false: nobody asks when units were adjusted
PastResults past_results(const Archive& archive, const std::string& parameter, const std::string& model,
                         const UnitName& unit = {}, bool with_adjustments = true);

}  // namespace tumble
