#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/dtg_centrifuge/fit.hpp"
#include "tumble/methods/dtg_centrifuge/ledger.hpp"

/// Parameters, tables and curves.
namespace tumble::dtg_centrifuge {

/// Everything identified of one output.
struct Outcome {
  Signal output = gyro;
  Take take = Take::both_parts;
  bool corrected = true;  ///< regression: bias by noise subtracted, nonlinearity from the polynomial
  std::vector<Observation> observations;
  Relation relation;
  Quantities levels;
  Polynomial polynomial;
  std::optional<Quantities> second, third;
  std::size_t power_ups = 1;
  Lag lag = {};
  double feigned_azimuth = 0.0;  ///< [rad] of the reference gyro, by one standard deviation of the lag
};

/// Adds parameters, tables, curves and findings of an output. The table and curves are those of the first output.
void describe(const Outcome& outcome, const std::vector<Measured>& measured, const Reduction& reduction, Ledger& ledger,
              Estimate& estimate);

/// The error models of the outputs whose D_x and D_y the result has: the drift over specific force, without D_xy, which
/// a rate of the table gives too.
std::vector<OutputModel> models_of(const Estimate& estimate, const std::vector<Level>& levels);

}  // namespace tumble::dtg_centrifuge
