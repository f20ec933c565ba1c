#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/models/model.hpp"
#include "tumble/units/sentence.hpp"

/// What every compensation does, whatever the form of its model: it finds its channels, takes terms and covariance from
/// the result, and writes beside each output how far it can be trusted.
namespace tumble::compensation {

/// Index of the channel that plays a role. Where the recording has none, or the channel is compensated already, this
/// goes to `problems` and nothing is returned.
std::optional<std::size_t> output_of(const Estimate& estimate, const Recording& recording, const std::string& role,
                                     Problems& problems);

/// Adds a problem where a channel is there and its dimension is not that of `unit`.
void require_dimension(const Channel* channel, const std::string& unit, Problems& problems);

/// A number [SI] of a result's table. Throws Error::bad_file where the cell holds text.
double number_in(const Table& table, const Table::Cell& cell);

/// Throws    Error::bad_data with all problems, each with the recording's file before it, where there are any
void refuse(const Recording& recording, std::vector<std::string> problems);

/// Terms that a result has coefficients for.
struct KnownTerms {
  std::vector<Term> terms;
  std::vector<double> coefficients;  ///< [SI]
  Matrix covariance;                 ///< [SI] n x n
};

/// Those of `candidates` that are parameters of the result, in the order of `candidates`.
/// Throws    Error::bad_file where one has no value, or is in a unit of another dimension than its term
KnownTerms known_terms(const Estimate& estimate, const std::vector<Term>& candidates);

/// What terms with known coefficients give at one sample.
struct Predicted {
  double value = 0.0;  ///< [SI] sum of the terms
  double sd = 0.0;     ///< [SI] its standard uncertainty by the covariance of the coefficients
};
/// Given     regressors  room for those of the n terms [SI], so that a loop over samples needs no memory of its own
/// Returned  value and uncertainty [SI]
Predicted predicted(const KnownTerms& known, const Felt& felt, std::vector<double>& regressors);

/// What a compensated output is written with.
struct Trust {
  Channel sd;            ///< <channel>.compensation_sd [as the output]: standard uncertainty of what was subtracted
  Channel extrapolated;  ///< <channel>.extrapolated: 1 where the calibration does not cover what was felt, else 0
};
/// Both as copies of the output, to be filled in.
Trust trust_in(const Channel& output);

}  // namespace tumble::compensation
