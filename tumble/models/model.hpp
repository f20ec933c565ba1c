#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/vector3.hpp"
#include "tumble/models/regressor.hpp"

namespace tumble {

/// Motion and temperature that the instrument feels at one instant, in its own axes.
struct Felt {
  Vector3 rate;                       ///< inertial angular rate [rad/s]
  Vector3 angular_acceleration;       ///< [rad/s^2]
  Vector3 specific_force;             ///< [m/s^2]
  double temperature = 293.15;        ///< [K]
  double temperature_gradient = 0.0;  ///< top minus side sensor [K]
  double temperature_rate = 0.0;      ///< [K/s]
  double start_temperature = 293.15;  ///< temperature over the first two minutes after power-on [K]
  double since_power_on = 0.0;        ///< [s]
};

/// One term of an error model: coefficient times regressor, in the unit of the output. The simulator sums the terms,
/// the estimator takes the regressors as its columns, the compensator subtracts them.
struct Term {
  std::string name;
  std::string symbol;
  std::string unit;  ///< of the coefficient, as shown
  std::string description;
  Regressor regressor;
};

/// One output of an instrument: the quantity that it is meant to show, and the error terms that it shows in addition.
///
///   indicated = input(felt) + sum of coefficient x regressor(felt) + turn-on bias + noise      [SI of the unit]
struct Output {
  std::string channel;  ///< "gyro", "accelerometer_x"
  QuantityKind kind = QuantityKind::angular_rate;
  std::string unit;          ///< as shown, of the indicated quantity
  Regressor input;           ///< empty: none
  std::vector<Term> terms;   ///< names are unique over all outputs of the model
  std::string noise_prefix;  ///< before the names of noise in [truth], for example "gyro_"
};

/// A part with memory between the indicated quantity and the recorded samples: loops, dither, counters. Takes the next
/// samples of the indicated quantity [SI] and puts what is recorded [SI of Recorded::unit] in their place. One object
/// for one output and one power-up, called block after block.
using Response = std::function<void(std::span<double> samples)>;

/// Adds to the indicated quantity [SI] what depends on the past of what was felt: heat on its way into a coil, for
/// example. Called as a Response is, with what is felt at the middle of every step.
using History = std::function<void(std::span<const Felt> felt, std::span<double> samples)>;

/// Quantity that a response records.
struct Recorded {
  QuantityKind kind = QuantityKind::angular_rate;
  std::string unit;
  bool accumulates = false;  ///< counts, increments: fine steps add up to a sample; else their mean is the sample
  Response response;         ///< null: the indicated quantity as it is
  History history = {};      ///< null: the terms say all; acts before the response
};

/// A catalogue entry of models/: an instrument as a table of terms, with the physics that gives the coefficients and
/// the electronics that record them.
struct Model {
  const char* name;
  const char* summary;
  const char* source;  ///< citation with equation numbers
  /// Options on which the regressors and the response themselves depend: time constants, bandwidth, range, kind of
  /// output.
  std::vector<Option> (*constants)();
  std::vector<Output> (*outputs)(const Settings& constants);
  /// Physical constants (masses, momenta, lengths) from which coefficients follow; null: none.
  std::vector<Option> (*physics)() = nullptr;
  /// Coefficients [SI] by term name that follow from the physics. A coefficient given in [truth] wins over these.
  std::map<std::string, double> (*coefficients)(const Settings& truth) = nullptr;
  /// The response of output number `output`; null: the indicated quantity is recorded as it is. `step` [s] is the time
  /// between the samples it will be given.
  Recorded (*record)(const Settings& truth, std::size_t output, double step, const RandomStream& random) = nullptr;
};

inline constexpr int most_oversampling = 100000;  ///< what is felt at the steps of one sample is held in memory

/// All that [truth] accepts for a model: a coefficient for every term, its constants, its physics, the noise and
/// turn-on repeatability of each kind of output, and `oversampling`.
std::vector<Option> truth_options(const Model& model);

/// The coefficients of one output's terms, in order [SI]: as given in [truth], else from the physics, else 0.
std::vector<double> coefficients_of(const Model& model, const Output& output, const Settings& truth);

/// The noise that the [truth] of a model states, with names that begin with `prefix`.
NoiseModel noise_of(const Settings& truth, const std::string& prefix = "");

/// A problem that a model has with its constants: the sentence behind "[truth]". Null: the problem is about something else.
const Sentence* about_truth(const Problem& problem);

/// The entry of that name, or Error::unsupported with the nearest known name.
const Model& find_model(std::string_view name);

/// All entries, in the order of their names.
const std::vector<const Model*>& model_catalogue();

}  // namespace tumble
