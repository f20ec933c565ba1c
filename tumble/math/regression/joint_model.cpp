#include "tumble/math/regression/joint_model.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/regression/mixed_model/estimator.hpp"
#include "tumble/math/regression/mixed_model/rows.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double white_of_known = 1e-10;  ///< [1] of the known variance, at least: outputs without noise

/// One output: its compressed rows over the sd of its white noise, and where they stand among those of all.
struct PartOfUnit {
  mixed_model::Compressed rows;
  VectorXd start, residuals;  ///< ordinary least squares
  double unit = 1.0;          ///< sd that the rows were divided by
  Index first_row = 0, first_parameter = 0;
};

/// Draws by name, as columns over the rows of all outputs.
struct Draws {
  std::vector<std::string> sources, names, keys;
  std::vector<bool> shared;
  std::vector<VectorXd> columns;
  std::map<std::string, std::size_t> known;

  VectorXd& column(const KnownEffect& effect, const std::string& name, Index rows) {
    const auto [place, is_new] = known.try_emplace(name, columns.size());
    if (is_new) {
      sources.push_back(effect.source);
      names.push_back(name);
      keys.push_back(effect.key);
      shared.push_back(!effect.draws.empty());
      columns.push_back(VectorXd::Zero(rows));
    }
    return columns[place->second];
  }
};

/// White noise as unit, or where there is none a small part of what else moves the rows, so that V stays positive.
double unit_of(const mixed_model::Compressed& rows, const MixedData& data, const MixedFit& alone) {
  double known = 0.0;
  const double n = static_cast<double>(std::max<Index>(1, rows.design.rows()));
  known += rows.effects.squaredNorm() / n;
  for (std::size_t c = 0; c < data.slow.size(); ++c)
    known += alone.slow_variance[c] * rows.incidence.squaredNorm() / n * map(data.slow[c].kernel).diagonal().maxCoeff();
  const double variance = std::max(alone.white_variance, white_of_known * known);
  return variance > 0.0 ? std::sqrt(variance) : 1.0;
}

std::vector<PartOfUnit> parts_of(std::span<const MixedData> outputs, std::span<const MixedFit> alone) {
  std::vector<PartOfUnit> parts;
  Index row = 0, parameter = 0;
  for (std::size_t c = 0; c < outputs.size(); ++c) {
    PartOfUnit part;
    part.rows = mixed_model::compress(outputs[c], std::sqrt(alone[c].white_variance));
    std::tie(part.start, part.residuals) = mixed_model::ordinary(part.rows);
    part.unit = unit_of(part.rows, outputs[c], alone[c]);
    part.rows.design /= part.unit;
    part.rows.effects /= part.unit;
    part.rows.incidence /= part.unit;
    part.residuals /= part.unit;
    part.first_row = row;
    part.first_parameter = parameter;
    row += part.rows.design.rows();
    parameter += part.rows.design.cols();
    parts.push_back(std::move(part));
  }
  return parts;
}

void add_draws(const MixedData& data, const PartOfUnit& part, std::size_t output, Index rows, Draws& draws) {
  for (std::size_t k = 0; k < data.effects.size(); ++k) {
    const auto& effect = data.effects[k];
    const auto name = [&](std::size_t segment) {
      if (!effect.draws.empty()) return effect.draws[effect.each_segment ? segment : 0];
      return fmt::format("{} of output {}, effect {}, segment {}", effect.source, output, k, segment);
    };
    const VectorXd& column = part.rows.effects.col(at(k));
    if (!effect.each_segment) {
      draws.column(effect, name(0), rows).segment(part.first_row, column.size()) += column;
      continue;
    }
    for (std::size_t g = 0; g < part.rows.parts.size(); ++g) {
      const auto [first, count] = part.rows.parts[g];
      const VectorXd shift = column.segment(first, count);
      if (shift.isZero(0.0)) continue;
      draws.column(effect, name(g), rows).segment(part.first_row + first, count) += shift;
    }
  }
}

/// V over the rows of all outputs: their noise is their own, the draws are common.
MatrixXd covariance_of(std::span<const MixedData> outputs, std::span<const MixedFit> alone,
                       const std::vector<PartOfUnit>& parts, const MatrixXd& draws) {
  MatrixXd v = draws * draws.transpose();
  v.diagonal().array() += 1.0;
  for (std::size_t c = 0; c < parts.size(); ++c) {
    const auto& incidence = parts[c].rows.incidence;
    for (std::size_t k = 0; k < outputs[c].slow.size(); ++k)
      v.block(parts[c].first_row, parts[c].first_row, incidence.rows(), incidence.rows()) +=
          alone[c].slow_variance[k] * incidence * map(outputs[c].slow[k].kernel) * incidence.transpose();
  }
  return v;
}

/// Sources of one name are one line.
void add_source(const std::string& source, const MatrixXd& covariance, MixedFit& fit) {
  const auto known = std::ranges::find(fit.sources, source, &SourceCovariance::source);
  if (known == fit.sources.end())
    fit.sources.push_back({source, plain(covariance)});
  else
    known->covariance = plain(map(known->covariance) + covariance);
}

/// Noise and slow noise of every output, in the order in which the likelihood found their variances.
void add_noise(std::span<const MixedData> outputs, std::span<const MixedFit> alone,
               const std::vector<PartOfUnit>& parts, const MatrixXd& gain, MixedFit& fit) {
  const auto add = [&](const std::string& source, const MatrixXd& of_unit, double variance) {
    add_source(source, variance * of_unit, fit);
    fit.component_sensitivity.push_back(plain(of_unit));
  };
  for (std::size_t c = 0; c < parts.size(); ++c) {
    const auto& rows = parts[c].rows;
    const MatrixXd own = gain.middleCols(parts[c].first_row, rows.design.rows());
    add(outputs[c].white, own * own.transpose() / (parts[c].unit * parts[c].unit), alone[c].white_variance);
    const MatrixXd shifts = own * rows.incidence;
    for (std::size_t k = 0; k < outputs[c].slow.size(); ++k)
      add(outputs[c].slow[k].source, shifts * map(outputs[c].slow[k].kernel) * shifts.transpose(),
          alone[c].slow_variance[k]);
  }
  const auto known = [](const MixedFit& one) { return one.component_covariance.empty(); };
  if (std::ranges::any_of(alone, known)) return;
  fit.component_covariance = Matrix(fit.component_sensitivity.size(), fit.component_sensitivity.size());
  std::size_t first = 0;
  for (const auto& one : alone) {
    const std::size_t size = one.component_covariance.rows;
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t j = 0; j < size; ++j)
        fit.component_covariance(first + i, first + j) = one.component_covariance(i, j);
    first += size;
  }
}

/// What every draw gives the parameters. A source of one draw alone is signed, with its key.
void add_draws(const Draws& draws, const MatrixXd& shifts, MixedFit& fit) {
  for (std::size_t k = 0; k < draws.sources.size(); ++k)
    add_source(draws.sources[k], shifts.col(at(k)) * shifts.col(at(k)).transpose(), fit);
  for (std::size_t k = 0; k < draws.sources.size(); ++k) {
    if (std::ranges::count(draws.sources, draws.sources[k]) > 1) continue;
    auto& source = *std::ranges::find(fit.sources, draws.sources[k], &SourceCovariance::source);
    source.shifts = plain(shifts.col(at(k)));
    source.key = draws.keys[k];
  }
}

/// Best prediction of the draws, D' V^-1 (y - X b), and what is left of their unit variance.
std::vector<FoundEffect> found(const Draws& draws, const MatrixXd& columns, const mixed_model::Estimator& estimator,
                               const VectorXd& residuals) {
  const VectorXd weighted = estimator.root.solve(residuals);
  std::vector<FoundEffect> effects;
  for (std::size_t k = 0; k < draws.names.size(); ++k) {
    if (!draws.shared[k]) continue;
    const VectorXd column = columns.col(at(k));
    const double told = column.dot(estimator.root.solve(column)) - (estimator.inner.transpose() * column).squaredNorm();
    effects.push_back(
        {draws.sources[k], draws.names[k], column.dot(weighted), std::sqrt(std::clamp(1.0 - told, 0.0, 1.0))});
  }
  return effects;
}

/// Adds the squares within the rows, the freedom and the fitted values of one output. Given: b, all parameters.
void add_output(const MixedData& output, const MixedFit& alone, const PartOfUnit& part, const VectorXd& b,
                MixedFit& fit) {
  if (alone.white_variance > 0.0) fit.chi_square += part.rows.within_squares / alone.white_variance;
  fit.degrees_of_freedom += alone.degrees_of_freedom;
  const VectorXd fitted = map(output.design) * b.segment(part.first_parameter, part.start.size());
  fit.fitted.insert(fit.fitted.end(), fitted.data(), fitted.data() + fitted.size());
}

}  // namespace

JointFit fit_joint_model(std::span<const MixedData> outputs, std::span<const MixedFit> alone) {
  if (outputs.empty() || outputs.size() != alone.size())
    throw Error(Error::Kind::internal, "joint model: every output needs the fit of its own");
  const auto parts = parts_of(outputs, alone);
  const Index n = parts.back().first_row + parts.back().rows.design.rows();
  const Index p = parts.back().first_parameter + parts.back().rows.design.cols();
  MatrixXd design = MatrixXd::Zero(n, p);
  VectorXd residuals(n), start(p);
  Draws draws;
  for (std::size_t c = 0; c < parts.size(); ++c) {
    const auto& [rows, begin, left, unit, row, parameter] = parts[c];
    design.block(row, parameter, rows.design.rows(), rows.design.cols()) = rows.design;
    residuals.segment(row, left.size()) = left;
    start.segment(parameter, begin.size()) = begin;
    add_draws(outputs[c], parts[c], c, n, draws);
  }
  MatrixXd columns(n, at(draws.columns.size()));
  for (std::size_t k = 0; k < draws.columns.size(); ++k) columns.col(at(k)) = draws.columns[k];
  const auto best = mixed_model::estimator(design, covariance_of(outputs, alone, parts, columns));

  JointFit out;
  MixedFit& fit = out.fit;
  const bool observed = !outputs.front().observations.empty();
  const VectorXd correction = best.gain * residuals, b = start + correction;
  fit.parameters.assign(b.data(), b.data() + p);
  add_noise(outputs, alone, parts, best.gain, fit);
  add_draws(draws, best.gain * columns, fit);
  MatrixXd total = MatrixXd::Zero(p, p);
  for (const auto& source : fit.sources) total += map(source.covariance);
  fit.covariance = plain(total);
  fit.condition = best.condition;
  const VectorXd last = residuals - design * correction;
  fit.chi_square = last.dot(best.root.solve(last));
  for (std::size_t c = 0; c < parts.size(); ++c) add_output(outputs[c], alone[c], parts[c], b, fit);
  if (observed) out.effects = found(draws, columns, best, last);
  return out;
}

}  // namespace tumble
