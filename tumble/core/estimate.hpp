#pragma once

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tumble/core/error_model.hpp"
#include "tumble/core/finding.hpp"
#include "tumble/core/prior.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/math/matrix.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {

/// One identified parameter. Value in SI; `unit` is what people are shown.
struct Parameter {
  std::string name;
  std::string symbol;
  Unit unit;
  double value = 0.0;
  std::string description;
  double degrees_of_freedom = std::numeric_limits<double>::infinity();  ///< of its standard uncertainty
  /// [SI] ends of the 95 % interval where it is not symmetric: standard deviations have one by chi-square. NaN: the
  /// interval is value -+ t sd.
  double lower = std::numeric_limits<double>::quiet_NaN(), upper = std::numeric_limits<double>::quiet_NaN();
  /// A term of the model that this test cannot separate from the parameter.
  struct Contained {
    std::string name;
    Unit unit;
    double weight = 0.0;  ///< [SI of the parameter/SI of the term]
  };
  /// The value is that of the parameter plus the sum of weight times term.
  std::vector<Contained> contains = {};
};

/// One line of the uncertainty budget: independent errors of unit variance, and what each of them does to every
/// parameter. The sum of factor x factor' over the budget is the covariance.
struct Contribution {
  std::string source;
  /// Fact that another result must have in common for the error to be the same there: equipment with its certificate, a
  /// site, a reference. Empty: the errors are this result's own.
  std::string key;
  Matrix factor;  ///< [SI] p x q, signed: the shift of each parameter (row) by one standard deviation of each error

  /// Variance [SI^2] that the line gives parameter number `parameter`.
  double variance(std::size_t parameter) const;
};

struct Fit {
  std::size_t observations = 0;
  double degrees_of_freedom = 0.0;
  double chi_square = 0.0;
  double condition = 0.0;  ///< of the whitened design with unit columns
};

/// A table for people. Numbers are in SI and shown in the column's unit; text stays as it is.
struct Table {
  struct Column {
    std::string name;
    Unit unit;
  };
  using Cell = std::variant<double, std::string>;
  std::string name;
  std::string caption;
  std::vector<Column> columns;
  std::vector<std::vector<Cell>> rows;
  bool for_programs = false;  ///< read by programs; not in the terminal text
};

/// A curve for people. Curves with the same `figure` are drawn in one figure. Values in SI, shown in the units.
struct Curve {
  struct Axis {
    std::string name;
    Unit unit;
    std::vector<double> values;
  };
  std::string name;
  std::string figure;
  Axis x, y;
  std::vector<double> lower, upper;  ///< band [SI, as y]; empty: none
  std::string band;                  ///< what the band is, for example "95 % confidence"
  bool logarithmic = false;          ///< both axes
  bool points = false;               ///< markers instead of a line
  bool logarithmic_x = false;        ///< the x axis alone
};

struct Verdict {
  enum class Outcome { pass, fail, undecided };  ///< undecided: the limit lies inside the 95 % interval
  std::string parameter;
  Outcome outcome = Outcome::undecided;
  std::string limit;  ///< "<= 0.02 deg/h"
};

/// All that an answer depends on: two tests that differ have different provenances.
struct Provenance {
  /// A file of numbers. Its name is relative to the folder of the plan, where there is one.
  struct Input {
    std::string file, sha256;
  };
  /// A plan as it was read: site, rig, schedule and limits are in its text.
  struct PlanFile {
    std::string file, sha256;
    std::optional<std::string> text;  ///< absent above 100 kB
  };
  std::vector<Input> inputs;
  std::vector<PlanFile> plans = {};                      ///< that of the test, then those of single recordings
  std::map<std::string, std::string> settings;           ///< of the method, resolved
  std::map<std::string, std::string> command_line = {};  ///< the values of `--set`, by key
  std::optional<unsigned long long> seed;                ///< of the simulation that made the data, where one did
};

/// Result of a method: parameters with a full covariance, and everything a reader needs to judge them.
struct Estimate {
  std::string method;
  std::string title;
  std::string instrument_model, instrument_serial;
  std::vector<Parameter> parameters;
  Matrix covariance;  ///< [SI], all contributions together
  std::vector<Contribution> budget;
  Fit fit;
  Findings findings;
  std::vector<Table> tables;
  std::vector<Curve> curves;
  std::vector<Verdict> verdicts;
  Provenance provenance;
  std::vector<OutputModel> models = {};             ///< how each output errs; empty: the result can subtract nothing
  std::optional<PopulationFacts> population = {};   ///< of an estimate of units that are not tested yet
  std::shared_ptr<const PriorUse> prior = nullptr;  ///< null: the plan asks for no prior
};

/// Standard uncertainty (k = 1) of parameter `index` [SI].
double standard_uncertainty(const Estimate& estimate, std::size_t index);
/// The estimate on which the verdicts rest: the estimate itself, or where the plan says so the one with prior.
const Estimate& judged(const Estimate& estimate);
/// The parameter of that name, or null.
const Parameter* find_parameter(const Estimate& estimate, std::string_view name);
/// Bound below which a parameter that the data do not show lies (95 %), as a finding says it.
struct UpperLimit {
  double value;  ///< [SI]
  Unit unit;     ///< that people are shown
};
/// Absent where the parameter has a value or no finding speaks of it.
std::optional<UpperLimit> find_upper_limit(const Estimate& estimate, std::string_view name);
/// The table of that name, or null.
const Table* find_table(const Estimate& estimate, std::string_view name);

}  // namespace tumble
