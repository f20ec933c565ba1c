#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tumble/reduce/compensate.hpp"
#include "tumble/reduce/compensation/outputs.hpp"

/// An error model while it is subtracted.
namespace tumble::compensation {

struct UsedTerm {
  Term term;
  std::size_t parameter = 0;
  double coefficient = 0.0, least = 0.0, greatest = 0.0;
  std::vector<std::size_t> missing;  ///< inputs
  std::set<std::string> from;        ///< where the others come from
  double sum = 0.0, squares = 0.0, largest = 0.0;
};

struct Counts {
  std::size_t samples = 0, outside = 0, blank = 0, lost = 0;
  double first_outside = 0.0;
};

/// A model with the numbers of a result, and its channel.
struct Work {
  const ErrorModel* model = nullptr;
  const Estimate* estimate = nullptr;
  std::vector<UsedTerm> terms, staying;  ///< subtracted, and those whose inputs are missing
  double scale_factor = 1.0, offset = 0.0;
  std::size_t scale_parameter = SIZE_MAX, offset_parameter = SIZE_MAX;
  double staying_variance = 0.0, spread_variance = 0.0;  ///< [SI^2] of u
  std::vector<std::size_t> others;                       ///< outputs that show an input of a term
  std::size_t place = 0;                                 ///< of the channel
  Trust trust;
  Counts counts;
  double y = 0.0, u = 0.0, slope = 0.0;           ///< of the present sample: (y - offset)/K, u, dE/du
  std::vector<std::pair<std::size_t, double>> d;  ///< of the present sample: derivatives of u by own parameters
};

/// A finding for the terms that cannot be subtracted because an input is missing.
void say_staying(const Work& work, const std::string& channel, Findings& findings);

/// Findings for samples outside of the calibration, without an input, without a solution.
void say(const Counts& counts, const std::string& channel, Findings& findings);

/// Table of each term's mean, sd and greatest size, and of where its inputs come from.
Table subtracted(const Work& work, const std::string& name, const Unit& unit);

}  // namespace tumble::compensation
