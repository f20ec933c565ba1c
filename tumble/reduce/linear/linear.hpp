#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/regression/mixed_model.hpp"
#include "tumble/models/model.hpp"

/// Linear identification of an instrument on a rig:
///
///   y = input(felt) + sum_j b_j x_j(felt) + rig errors + slow noise + white noise
///
/// with felt as the plan's rig says it, the columns x_j from the table of terms that also simulates the instrument.
/// One Problem is identified from Evidence or predicted from a Plan; only the data differ.
namespace tumble::linear {

/// An uncertainty of the reading itself, common to the whole test: a scale factor taken from elsewhere, for example.
struct ReadingError {
  std::string source;  ///< as the budget names it
  double sd = 0.0;
  /// Change of the output by a unit of the error, where `predicted` [SI] is what the model gives.
  std::function<double(const Felt& felt, double predicted)> change;
};

/// An uncertainty of the response: the response as it would be, off by one standard deviation.
struct ResponseError {
  std::string source;
  std::function<Response(double step)> response;
};

/// The unknowns, and how the output is read.
struct Problem {
  std::string role = "gyro";  ///< the channel
  double scale = 1.0;         ///< output [SI] for one SI unit of the channel
  /// Output integrated over one pulse [SI s], where the channel counts pulses: rounding to whole ones is then a source
  /// of its own, since it grows neither with time nor with the number of samples. 0: no pulses.
  double pulse = 0.0;
  Regressor input;            ///< known part of the output [SI]; empty: none
  std::vector<Term> columns;  ///< y - input = sum of coefficient x regressor
  std::vector<ReadingError> reading_errors;
  /// Linear response between the indicated quantity and the samples (the rebalance loop): input and columns
  /// pass through it, with a state of their own each. Null: nothing. See Response.
  std::function<Response(double step)> response;
  std::vector<ResponseError> response_errors;
  /// Whole averages where the rig turns but what is felt hardly changes (about the vertical): many fewer rows; an
  /// error that turns with the axis is then one error per segment. Always on for pulse counters.
  bool even_averages = false;
  int oversampling = 1;                      ///< points in each sample at which a moving rig is asked
  std::vector<std::string> leave_out_first;  ///< columns, in this order, where the schedule cannot show all
  /// In [phrase]: what to add to the test so that it can.
  Phrase advice{"distinguish_by_other_segments"};
  double condition_limit = weakest_combination;  ///< beyond, the weakest combination is not used
  double settling = 0.0;                         ///< [s] skipped after the rig has settled in each segment
  double averaging = 1.0;                        ///< [s] of a block
  bool needs_site = true;                        ///< without the Earth's rate and gravity the input is wrong
  /// A segment in which an axis slews is used from rest to rest as one total, whatever way it took; of one at a rate as
  /// many whole turns as it holds. The counted pulses of a move give its angle, independent of its course.
  bool whole_moves = false;
  /// Bias instability [SI of what `stated_per` names, or of the output] known beforehand: few segments cannot show it.
  /// 0: found from the segments.
  double bias_instability = 0.0;
  std::string stated_by = "bias_instability";  ///< the setting that gives it
  std::string stated_per = {};                 ///< column by whose coefficient it moves the output; empty: 1
  bool rests_only = false;                     ///< segments in which an axis moves are skipped
};

/// One segment of the evidence. Means over the samples used [SI].
struct SegmentSummary {
  std::string label;
  int run = 1;
  double begin = 0.0;     ///< [s] since power-on, of the first sample used
  double duration = 0.0;  ///< [s] of the samples used
  bool steady = false;
  Felt felt;               ///< mean
  double measured = 0.0;   ///< NaN where predicted
  double predicted = 0.0;  ///< input and model
  double sd = 0.0;         ///< of the mean: white noise, and the rounding of a coarse output
  double rounding = 0.0;   ///< [SI] the part of this rounding: alike in segments of one input
};

/// Condition limit of a test that moves: its axes are known to 1e-3 only, and a weaker combination is made of their
/// errors.
constexpr double weakest_in_motion = 1e3;

/// Whether two segments have one input: within 10 ug, and within 2e-4 deg/h.
inline bool is_same_input(const Felt& a, const Felt& b) {
  constexpr double same_force = 1e-4, same_rate = 1e-9;  // [m/s^2], [rad/s]
  return norm(a.specific_force - b.specific_force) < same_force && norm(a.rate - b.rate) < same_rate;
}

struct Solution {
  std::vector<Term> columns;          ///< those used, in the order of MixedFit::parameters
  std::vector<std::string> channels;  ///< of each column: the role of its output
  MixedFit fit;
  OutputModel output;                   ///< role, quantity and reading of the output, without terms
  std::vector<double> least, greatest;  ///< of each column's regressor over the data used [SI]
  std::vector<SegmentSummary> segments;
  std::vector<Dropped> dropped;                   ///< indices of Problem::columns
  std::vector<std::size_t> hidden_by_schedule;    ///< those of them that the whole schedule does not show either
  std::map<std::string, std::string> stands_for;  ///< by name of a column used: "D_F + D_OO", where it is not itself
  std::map<std::string, std::vector<Parameter::Contained>> contains;  ///< the same as numbers
  std::size_t observations = 0;
  double drift_sd = 0.0;  ///< [SI] by which segments differ beyond model, rig errors and white noise; 0 if predicted
  Findings findings;      ///< which columns are not used, and what the others then mean
  /// [SI] of the columns: shifts by terms that the model may lack, each as large as it is likely; none: none is suspected.
  std::vector<std::vector<double>> doubt;
};

/// The terms of these names from the table of a model's output, in the order given.
std::vector<Term> terms_of(const std::string& model, const Settings& constants, const std::vector<std::string>& names);

/// The options every method on this engine has: `settling`, `averaging`, `oversampling`.
std::vector<Option> options(const std::string& settling, const std::string& averaging);
/// `bias_instability`, after a prefix where a method has outputs of several kinds.
Option bias_instability_option(const std::string& unit, const std::string& prefix = "");
/// Value [SI] of that option; 0: it is absent.
double stated_bias_instability(const Settings& settings, const std::string& prefix);
/// Puts the options into a problem.
void set_options(const Settings& settings, Problem& problem, const std::string& noise_prefix = "");

/// `natural_frequency`, `damping_ratio` and `loop_lag_sd` of a rebalance or servo loop.
std::vector<Option> loop_options();
/// The model's loop as the problem's response, with the uncertainty of its lag, where `natural_frequency` is given.
void set_loop(const Settings& settings, const std::string& model, Problem& problem);

/// How much is to be said of a column that is not used: a convention of the test where its schedule cannot show it in
/// any case (a field of 1 g shows no sum of the squares), else a lack of these recordings.
Finding::Severity severity_of(const Dropped& dropped, const Solution& solution);

/// Throws Error::bad_data, bad_input with all that the plan or the recordings lack.
Solution identify(const Evidence& evidence, const Problem& problem);

/// Around what a test is predicted.
struct Truth {
  std::map<std::string, double> coefficients;  ///< by column name [SI]; absent: 0
  NoiseModel noise;
  double turn_on_sd = 0.0;  ///< of the bias, from power-up to power-up [SI]
};

/// Truth of the output called `channel` by the plan's [truth] and model.
/// Throws Error::bad_input where the plan lacks model or truth.
Truth truth_of(const Plan& plan, const std::string& channel);

/// The uncertainties from the rows without data, of the plan and of the plans that its recordings name: white noise,
/// slow noise of the segments (flicker, random walk and Markov noise, correlated between them in closed form), turn-on
/// and rig.
Solution predict(const Plan& plan, const Problem& problem, const Truth& truth);

/// Fisher information of single segments, additive: of the columns and of the errors common to all segments.
struct Information {
  std::size_t columns = 0;          ///< of Problem; the first rows of each matrix
  std::vector<std::string> errors;  ///< common errors, in units of their sd: the rows that follow; prior information 1
  std::vector<Matrix> of_segment;   ///< one a segment of the schedule, [SI]; zero where a segment gives no samples
};

/// Information of each segment of the plan's schedule alone: A' V^-1 A with A = [X | common errors], V white noise,
/// slow noise independent between segments, and the errors drawn anew for each. Add those of the segments chosen, and 1
/// on the diagonal of the errors; the inverse's first block is the covariance of the coefficients.
Information information(const Plan& plan, const Problem& problem, const Truth& truth);

/// Parameters, covariance, budget, fit and findings of a solution.
Estimate estimate_of(const Solution& solution);

/// A mean of an input [SI] without what is rounding alone: the cosine of 90 deg.
Vector3 without_rounding(Vector3 mean);

/// Table `positions`: label, specific force along the axes named (x, y, z of Felt), with `rate_unit` also the rates,
/// predicted and measured output, residual.
Table positions(const Solution& solution, const std::string& channel_unit, const std::vector<std::string>& axes,
                const std::string& rate_unit = "");

/// The solution as an estimate, with the error model, the table `positions` and, of an
/// identification, a warning where the segments differ from the model by 30 times what the white noise within them lets
/// expect: a wrong scale factor or sign, clipped or exchanged segments hide there. (Slow noise of a sound instrument
/// stays within ten times.)
Estimate answer_of(const Solution& solution, const std::string& channel_unit, const std::vector<std::string>& axes,
                   const std::string& rate_unit = "");

}  // namespace tumble::linear
