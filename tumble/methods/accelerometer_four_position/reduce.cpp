#include "tumble/methods/accelerometer_four_position/reduce.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "tumble/methods/accelerometer_four_position/components.hpp"
#include "tumble/units/error.hpp"

namespace tumble::methods::four {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Index at(std::size_t i) { return static_cast<Index>(i); }

Eigen::Map<const MatrixXd> map(const Matrix& m) { return {m.values.data(), at(m.rows), at(m.columns)}; }

Matrix plain(const MatrixXd& m) {
  Matrix out(static_cast<std::size_t>(m.rows()), static_cast<std::size_t>(m.cols()));
  Eigen::Map<MatrixXd>(out.values.data(), m.rows(), m.cols()) = m;
  return out;
}

constexpr double freezing = 273.15;  ///< [K]

/// Results of all cells in one vector z, quantity after quantity, and d z/d (output of each stretch).
struct Stacked {
  std::vector<Quantity> active;
  std::size_t cells = 0;
  VectorXd z;
  MatrixXd slope;

  Index index(std::size_t block, std::size_t cell) const { return at(block * cells + cell); }
};

FourResults results_of(const Bench& bench, const Cell& cell, bool two) {
  const auto output = [&](std::size_t position) { return bench.positions[position].output; };
  const double gravity = bench.positions[cell.up].gravity;
  if (two) return from_two({output(cell.up), 0.0, output(cell.down), 0.0}, gravity);
  return from_four({output(cell.up), output(*cell.second), output(cell.down), output(*cell.fourth)}, gravity,
                   cell.o_level ? -1.0 : 1.0);
}

/// The same number up and down, or nothing finite: there is no scale factor.
void refuse_flat(const Bench& bench, const Stacked& all) {
  std::vector<std::string> problems;
  for (std::size_t c = 0; c < all.cells; ++c) {
    bool good = true;
    for (std::size_t b = 0; b < all.active.size(); ++b) good = good && std::isfinite(all.z[all.index(b, c)]);
    if (!good)
      problems.push_back(fmt::format("run {}, {}: positions 1 and 3 show the same output", bench.cells[c].run,
                                     in_words(bench.cells[c].temperature)));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

Stacked stacked_of(const Bench& bench, bool two) {
  Stacked all;
  all.active =
      two ? std::vector{bias, scale_factor_error} : std::vector{bias, scale_factor_error, second_order, misalignment};
  all.cells = bench.cells.size();
  const Index n = at(all.active.size() * all.cells);
  all.z = VectorXd::Zero(n);
  all.slope = MatrixXd::Zero(n, at(bench.evidence.stretches.size()));
  for (std::size_t c = 0; c < all.cells; ++c) {
    const Cell& cell = bench.cells[c];
    const FourResults results = results_of(bench, cell, two);
    for (std::size_t b = 0; b < all.active.size(); ++b) {
      const Index i = all.index(b, c);
      const auto& slope = results.slope[all.active[b]];
      all.z[i] = results.value[all.active[b]];
      const auto set = [&](std::size_t position, double value) {
        all.slope(i, at(bench.positions[position].stretch)) = value;
      };
      set(cell.up, slope[0]);
      set(cell.down, slope[2]);
      if (two) continue;
      set(*cell.second, slope[1]);
      set(*cell.fourth, slope[3]);
    }
  }
  refuse_flat(bench, all);
  return all;
}

/// Powers of the centred and scaled temperature; one column for what does not depend on it.
struct Design {
  MatrixXd x;
  std::vector<std::size_t> counts;  ///< columns by block
  double centre = 0.0, half = 1.0;  ///< [K]
};

std::size_t columns_of(Quantity quantity, std::size_t order) {
  return quantity == bias || quantity == scale_factor_error ? order + 1 : 1;
}

Design design_of(const Bench& bench, const Stacked& all, std::size_t order) {
  Design design;
  const double low = bench.group_temperature.front(), high = bench.group_temperature.back();
  design.centre = 0.5 * (low + high);
  design.half = std::max(1.0, 0.5 * (high - low));
  Index columns = 0;
  for (const auto quantity : all.active) {
    design.counts.push_back(columns_of(quantity, order));
    columns += at(design.counts.back());
  }
  design.x = MatrixXd::Zero(all.z.size(), columns);
  Index column = 0;
  for (std::size_t b = 0; b < all.active.size(); ++b)
    for (std::size_t k = 0; k < design.counts[b]; ++k, ++column)
      for (std::size_t c = 0; c < all.cells; ++c)
        design.x(all.index(b, c), column) =
            std::pow((bench.cells[c].temperature - design.centre) / design.half, static_cast<double>(k));
  return design;
}

/// From the centred polynomials to plain ones in T [degC]:
///
///   sum_k beta_k ((T - T_0)/h)^k = sum_j b_j T^j,  b_j = sum_k beta_k/h^k binomial(k, j) (-T_0)^(k - j)
MatrixXd to_plain(const Design& design) {
  MatrixXd convert = MatrixXd::Zero(design.x.cols(), design.x.cols());
  Index first = 0;
  for (const std::size_t count : design.counts) {
    for (std::size_t k = 0; k < count; ++k) {
      double binomial = 1.0;
      for (std::size_t j = 0; j <= k; ++j) {
        convert(first + at(j), first + at(k)) = binomial *
                                                std::pow(-(design.centre - freezing), static_cast<double>(k - j)) /
                                                std::pow(design.half, static_cast<double>(k));
        binomial *= static_cast<double>(k - j) / static_cast<double>(j + 1);
      }
    }
    first += at(count);
  }
  return convert;
}

struct Source {
  std::string name;
  MatrixXd covariance;  ///< of z
};

void add(std::vector<Source>& sources, const std::string& name, const MatrixXd& covariance) {
  const auto found = std::ranges::find(sources, name, &Source::name);
  if (found == sources.end())
    sources.push_back({name, covariance});
  else
    found->covariance += covariance;
}

/// What the instrument shows as found so far, as one column with the coefficient 1: the rig's errors act through it.
Term whole_model(const Stacked& all, const VectorXd& plain_parameters, const Design& design, bool o_level) {
  std::vector<std::vector<double>> parts(quantities);
  Index first = 0;
  for (std::size_t b = 0; b < all.active.size(); ++b) {
    for (std::size_t k = 0; k < design.counts[b]; ++k) parts[all.active[b]].push_back(plain_parameters[first + at(k)]);
    first += at(design.counts[b]);
  }
  const auto value = [](const std::vector<double>& part, double celsius) {
    double sum = 0.0;
    for (std::size_t j = part.size(); j-- > 0;) sum = sum * celsius + part[j];
    return sum;
  };
  return {"model", "", "1", "", [=](const Felt& felt) {
            const double celsius = felt.temperature - freezing;
            const Vector3 f = felt.specific_force;
            const double scale = 1.0 / (1.0 + value(parts[scale_factor_error], celsius));
            const double theta = value(parts[misalignment], celsius);
            const double inner = f.x + value(parts[bias], celsius) + value(parts[second_order], celsius) * f.x * f.x +
                                 (o_level ? -theta * f.z : theta * f.y);
            return scale * inner - f.x;
          }};
}

/// White noise, counting and the errors of the rig, as covariances of z.
std::vector<Source> known_sources(const Bench& bench, const Stacked& all, const Term& model) {
  std::vector<Source> sources;
  const Index stretches = all.slope.cols();
  VectorXd noise = VectorXd::Zero(stretches), counting = VectorXd::Zero(stretches);
  for (const auto& position : bench.positions) {
    noise[at(position.stretch)] = bench.white / position.seconds;
    counting[at(position.stretch)] = bench.pulse * bench.pulse / 6.0 / (position.seconds * position.seconds);
  }
  add(sources, "output noise", all.slope * noise.asDiagonal() * all.slope.transpose());
  if (bench.pulse > 0.0) add(sources, "counting", all.slope * counting.asDiagonal() * all.slope.transpose());
  linear::Problem problem = bench.problem;
  problem.columns = {model};
  for (const auto& effect : linear::effects_of(bench.evidence, problem, bench.rows, {1.0})) {
    VectorXd shift = VectorXd::Zero(stretches);
    for (std::size_t i = 0; i < effect.column.size(); ++i) shift[at(bench.rows.segment[i])] = effect.column[i];
    const VectorXd moved = all.slope * shift;
    if (effect.each_segment)
      add(sources, effect.source, all.slope * shift.cwiseAbs2().asDiagonal() * all.slope.transpose());
    else
      add(sources, effect.source, moved * moved.transpose());
  }
  return sources;
}

/// Temperatures read wrong by `sd` throughout.
void add_thermometer(const Bench& bench, const Stacked& all, const Design& design, const VectorXd& centred, double sd,
                     std::vector<Source>& sources) {
  if (!(sd > 0.0)) return;
  VectorXd shift = VectorXd::Zero(all.z.size());
  Index first = 0;
  for (std::size_t b = 0; b < all.active.size(); ++b) {
    for (std::size_t c = 0; c < all.cells; ++c) {
      const double u = (bench.cells[c].temperature - design.centre) / design.half;
      for (std::size_t k = 1; k < design.counts[b]; ++k)
        shift[all.index(b, c)] += sd * centred[first + at(k)] * static_cast<double>(k) *
                                  std::pow(u, static_cast<double>(k - 1)) / design.half;
    }
    first += at(design.counts[b]);
  }
  add(sources, "thermometer", shift * shift.transpose());
}

/// A variance that is not known beforehand: name, what a unit of it does to z, its size and uncertainty.
struct Unknown {
  std::string name;
  MatrixXd kernel;  ///< of z
  double variance = 0.0;
  std::size_t block = 0;
};

MatrixXd same_power_up(const Bench& bench) {
  const Index n = at(bench.cells.size());
  MatrixXd kernel = MatrixXd::Zero(n, n);
  for (Index a = 0; a < n; ++a)
    for (Index b = 0; b < n; ++b)
      kernel(a, b) =
          bench.cells[static_cast<std::size_t>(a)].power_up == bench.cells[static_cast<std::size_t>(b)].power_up;
  return kernel;
}

/// One mean for each temperature: what repeats differ by from these knows nothing of the polynomial.
MatrixXd means_by_temperature(const Bench& bench) {
  MatrixXd x = MatrixXd::Zero(at(bench.cells.size()), at(bench.group_temperature.size()));
  for (std::size_t c = 0; c < bench.cells.size(); ++c) x(at(c), at(bench.cells[c].group)) = 1.0;
  return x;
}

/// The variances of one quantity: of single cells, and of power-ups where these can be told from them.
struct Found {
  std::vector<Unknown> unknown;
  MatrixXd covariance;  ///< of the variances
};

Found repeatability_of(const Bench& bench, const Stacked& all, std::size_t block, const MatrixXd& x,
                       const MatrixXd& known, bool repeated) {
  const Index n = at(all.cells), first = all.index(block, 0);
  std::vector<Matrix> kernels{plain(MatrixXd::Identity(n, n))};
  std::vector<std::string> names{repeated ? "repeatability" : "scatter about the polynomial"};
  const MatrixXd together = same_power_up(bench);
  std::set<std::size_t> power_ups;
  for (const auto& cell : bench.cells) power_ups.insert(cell.power_up);
  if (power_ups.size() > 1 && power_ups.size() < all.cells && n - x.cols() >= 3) {
    kernels.push_back(plain(together));
    names.emplace_back("turn-on repeatability");
  }
  const VectorXd z = all.z.segment(first, n);
  const Components found =
      components_of(plain(x), {z.data(), z.data() + n}, plain(known.block(first, first, n, n)), kernels);
  Found out;
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    MatrixXd kernel = MatrixXd::Zero(all.z.size(), all.z.size());
    kernel.block(first, first, n, n) = map(kernels[k]);
    out.unknown.push_back({names[k], std::move(kernel), found.variance[k], block});
  }
  out.covariance = map(found.covariance);
  return out;
}

/// Each quantity is weighted by its own covariance: what K_2 does over temperature is not to move the bias.
MatrixXd for_weights(MatrixXd v, Index cells) {
  for (Index i = 0; i < v.rows(); ++i)
    for (Index j = 0; j < v.cols(); ++j)
      if (i / cells != j / cells) v(i, j) = 0.0;
  return v;
}

MatrixXd sum_of(const std::vector<Source>& sources, Index n) {
  MatrixXd v = MatrixXd::Zero(n, n);
  for (const auto& source : sources) v += source.covariance;
  return v;
}

/// The estimator z -> beta, V made positive where the data are free of noise.
struct Estimator {
  MatrixXd gain;
  double chi_square = 0.0, condition = 0.0;
};

Estimator estimator(const MatrixXd& x, const VectorXd& z, const MatrixXd& v) {
  // Quantities have units of their own: V is scaled to a unit diagonal. Rows without any noise count as one part in 1e9
  // of the largest of their kind.
  VectorXd unit = v.diagonal().cwiseSqrt();
  for (Index i = 0; i < unit.size(); ++i) unit[i] = std::max(unit[i], 1e-14 * (1.0 + std::abs(z[i])));
  MatrixXd scaled = unit.cwiseInverse().asDiagonal() * v * unit.cwiseInverse().asDiagonal();
  scaled.diagonal().array() += 1e-9;
  const Eigen::LLT<MatrixXd> root(scaled);
  const MatrixXd white = root.matrixL().solve(unit.cwiseInverse().asDiagonal() * x);
  const VectorXd seen = root.matrixL().solve(unit.cwiseInverse().asDiagonal() * z);
  const VectorXd size = white.colwise().norm().cwiseInverse();
  const MatrixXd even = white * size.asDiagonal();
  const Eigen::HouseholderQR<MatrixXd> qr(even);
  const MatrixXd inverse = qr.solve(root.matrixL().solve(MatrixXd(unit.cwiseInverse().asDiagonal())));
  Estimator out{size.asDiagonal() * inverse};
  out.chi_square = (seen - white * (out.gain * z)).squaredNorm();
  const Eigen::JacobiSVD<MatrixXd> svd(even);
  out.condition = svd.singularValues()[0] / svd.singularValues()[even.cols() - 1];
  return out;
}

void fill_cells(const Stacked& all, const MatrixXd& v, Reduced& out) {
  out.cells.resize(all.cells);
  for (std::size_t b = 0; b < all.active.size(); ++b)
    for (std::size_t c = 0; c < all.cells; ++c) {
      const Index i = all.index(b, c);
      out.cells[c].value[all.active[b]] = all.z[i];
      out.cells[c].sd[all.active[b]] = std::sqrt(v(i, i));
    }
}

}  // namespace

std::vector<double> powers(double temperature, std::size_t count) {
  std::vector<double> out;
  for (std::size_t j = 0; j < count; ++j) out.push_back(std::pow(temperature - freezing, static_cast<double>(j)));
  return out;
}

double at_temperature(const std::vector<double>& parameters, const Polynomial& polynomial, double temperature) {
  double sum = 0.0;
  const auto t = powers(temperature, polynomial.count);
  for (std::size_t j = 0; j < polynomial.count; ++j) sum += t[j] * parameters[polynomial.first + j];
  return sum;
}

Reduced reduce(const Bench& bench, std::size_t order, bool two, double thermometer_sd, const Expected* expected) {
  const Stacked all = stacked_of(bench, two);
  const Design design = design_of(bench, all, order);
  const MatrixXd convert = to_plain(design);
  const VectorXd look = design.x.colPivHouseholderQr().solve(all.z);
  auto sources = known_sources(bench, all, whole_model(all, convert * look, design, bench.cells.front().o_level));
  add_thermometer(bench, all, design, look, thermometer_sd, sources);

  Reduced out;
  out.active = all.active;
  out.repeated = bench.cells.size() > bench.group_temperature.size();
  const std::size_t fixed = out.repeated ? bench.group_temperature.size() : order + 1;
  out.repeatability_known = !expected && bench.cells.size() > fixed;
  const MatrixXd known = sum_of(sources, all.z.size());
  std::vector<Found> found;
  for (std::size_t b = 0; b < all.active.size() && out.repeatability_known; ++b) {
    Index first = 0;
    for (std::size_t before = 0; before < b; ++before) first += at(design.counts[before]);
    const MatrixXd x = out.repeated
                           ? means_by_temperature(bench)
                           : MatrixXd(design.x.block(all.index(b, 0), first, at(all.cells), at(design.counts[b])));
    found.push_back(repeatability_of(bench, all, b, x, known, out.repeated));
    out.repeatability[all.active[b]] = std::sqrt(found.back().unknown.front().variance);
  }
  if (expected && expected->turn_on_sd > 0.0) {
    MatrixXd kernel = MatrixXd::Zero(all.z.size(), all.z.size());
    kernel.topLeftCorner(at(all.cells), at(all.cells)) = same_power_up(bench);
    add(sources, "turn-on repeatability", expected->turn_on_sd * expected->turn_on_sd * kernel);
  }
  for (const auto& one : found)
    for (const auto& unknown : one.unknown) add(sources, unknown.name, unknown.variance * unknown.kernel);

  const MatrixXd v = sum_of(sources, all.z.size());
  const Estimator estimate = estimator(design.x, all.z, for_weights(v, at(all.cells)));
  const MatrixXd gain = convert * estimate.gain;
  const VectorXd parameters = gain * all.z;
  out.parameters.assign(parameters.data(), parameters.data() + parameters.size());
  MatrixXd total = MatrixXd::Zero(gain.rows(), gain.rows());
  for (const auto& source : sources) {
    const MatrixXd covariance = gain * source.covariance * gain.transpose();
    total += covariance;
    out.sources.push_back({source.name, plain(covariance)});
  }
  out.covariance = plain(total);
  std::size_t next = 0;
  for (std::size_t b = 0; b < all.active.size(); ++b) {
    out.polynomial[all.active[b]] = {next, design.counts[b]};
    next += design.counts[b];
  }

  // Welch-Satterthwaite: nu = 2 v^2/Var(v), Var(v) from the variances that were found and that of the white noise
  for (Index j = 0; j < gain.rows(); ++j) {
    double of_v = 0.0;
    if (bench.white_freedom > 0.0) {
      const double share = out.sources.front().covariance(static_cast<std::size_t>(j), static_cast<std::size_t>(j));
      of_v += 2.0 * share * share / bench.white_freedom;
    }
    for (const auto& one : found) {
      VectorXd slope(at(one.unknown.size()));
      for (std::size_t k = 0; k < one.unknown.size(); ++k)
        slope[at(k)] = gain.row(j).dot(one.unknown[k].kernel * gain.row(j).transpose());
      of_v += slope.dot(one.covariance * slope);
    }
    out.degrees_of_freedom.push_back(of_v > 0.0 ? std::max(1.0, 2.0 * total(j, j) * total(j, j) / of_v)
                                                : std::numeric_limits<double>::infinity());
  }
  fill_cells(all, v, out);
  out.fit.observations = static_cast<std::size_t>(all.z.size());
  out.fit.degrees_of_freedom = static_cast<double>(all.z.size() - gain.rows());
  out.fit.chi_square = estimate.chi_square;
  out.fit.condition = estimate.condition;
  return out;
}

}  // namespace tumble::methods::four
