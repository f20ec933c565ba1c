#pragma once

#include <cstddef>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tumble/reduce/compensate.hpp"
#include "tumble/reduce/compensation/inputs.hpp"
#include "tumble/reduce/compensation/outputs.hpp"

/// An error model while it is subtracted.
namespace tumble::compensation {

struct UsedFactor {
  TermFactor::Form form = TermFactor::Form::power;
  int order = 1;
  double origin = 0.0, size = 1.0;  ///< [SI of the input]
  std::size_t slot = 0;
  std::size_t start = SIZE_MAX;                             ///< slot of the start temperature, where it is subtracted
  bool linear = false;                                      ///< it is the input less the origin
  double state = std::numeric_limits<double>::quiet_NaN();  ///< of a play, before the present sample
};

struct UsedProduct {
  double weight = 1.0;
  std::vector<UsedFactor> factors;
};

struct UsedTerm {
  std::string name;
  std::size_t parameter = SIZE_MAX;  ///< SIZE_MAX: the coefficient is no parameter
  double coefficient = 1.0, least = 0.0, greatest = 0.0;
  bool per_output = false, has_play = false;
  std::vector<UsedProduct> products;
  std::set<std::size_t> slots;    ///< that it needs
  bool remains = false;           ///< it is never subtracted
  std::set<std::string> missing;  ///< inputs
  std::set<std::string> from;     ///< where the others come from
  double sum = 0.0, squares = 0.0, largest = 0.0;
};

/// A sum of inputs with constant coefficients: what most error models consist of.
struct LinearPart {
  double constant = 0.0;                                   ///< [SI of u]
  std::vector<std::pair<std::size_t, double>> of_slots{};  ///< slots, and dE/dx [SI of u/SI of x]
  std::vector<double> slopes{};                            ///< the same of each slot
};

struct Counts {
  std::size_t samples = 0, outside = 0, blank = 0, lost = 0;
  double first_outside = 0.0;
};

/// A model with the numbers of a result, and its channel.
struct Work {
  const OutputModel* model = nullptr;
  const Estimate* estimate = nullptr;
  std::size_t shown = 0;                              ///< slot of u
  std::vector<UsedTerm> terms, staying;               ///< subtracted, and those that stay in
  std::vector<std::vector<std::size_t>> terms_with;   ///< of each slot: those of `terms` that depend on it
  LinearPart linear;                                  ///< of the errors: the terms that are proportional to inputs
  std::vector<std::size_t> curved;                    ///< the other ones of `terms`
  std::vector<std::vector<std::size_t>> curved_with;  ///< of each slot: those that depend on it
  double reading = 1.0;                               ///< [SI of K u per SI of the channel]
  double scale_factor = 1.0, offset = 0.0, delay = 0.0;
  double staying_variance = 0.0, spread_variance = 0.0;  ///< [SI^2] of u
  std::vector<Covered> covered;                          ///< whose inputs are known
  std::vector<std::size_t> others;                       ///< outputs that show an input of a term
  std::size_t place = 0;                                 ///< of the channel
  std::vector<double> late;                              ///< [SI] what it shows, with its delay; empty: as recorded
  Trust trust;
  Counts counts;
  double y = 0.0, u = 0.0, slope = 0.0;           ///< of the present sample: (y - offset)/K, u, dE/du
  std::vector<std::pair<std::size_t, double>> d;  ///< of the present sample: derivatives of u by own parameters
};

using Works = std::vector<Work>;

using Values = std::vector<double>;  ///< [SI] of all slots at one sample

/// The regressor [SI]; states of plays are not changed.
double regressor_of(const UsedTerm& term, const Values& values);
/// The states of plays after this sample.
void advance(UsedTerm& term, const Values& values);
/// Plays have no state yet.
void begin(UsedTerm& term);

/// The terms of a model with the coefficients of the result, whose factors are slots of `slots`: new ones are added.
/// Throws    Error::bad_file where a parameter has no value
std::vector<UsedTerm> used_terms(const OutputModel& model, const Estimate& estimate, std::vector<Slot>& slots);

/// Finds which terms depend on which slots, and their linear part.
void sort_by_slots(Work& work, std::size_t slot_count);

/// A finding for the terms that cannot be subtracted because an input is missing.
void say_staying(const Work& work, const std::string& channel, Findings& findings);

/// Findings for samples outside of the calibration, without an input, without a solution.
void tell(const Counts& counts, const std::string& channel, Findings& findings);

/// Table of each term's mean, sd and greatest size, and of where its inputs come from.
Table subtracted(const Work& work, const std::string& name, const Unit& unit);

}  // namespace tumble::compensation
