#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/results/reader.hpp"
#include "tumble/math/matrix3.hpp"

namespace tumble::results {
namespace {

constexpr const char* letters = "xyz";

/// Greatest rates and forces: of the table `covered`, else of the table `regressors`.
void set_ranges(Reader& reader) {
  ImuCalibration& c = reader.calibration();
  if (const Table* covered = find_table(reader.estimate(), "covered");
      covered && covered->rows.size() == 3 && covered->columns.size() == 3)
    for (std::size_t i = 0; i < 3; ++i) {
      c.gyros.range[i] = reader.cell(*covered, i, 1);
      c.accelerometers.range[i] = reader.cell(*covered, i, 2);
    }
  const Table* regressors = find_table(reader.estimate(), "regressors");
  if (!regressors || regressors->columns.size() != 3) return;
  for (std::size_t r = 0; r < regressors->rows.size(); ++r)
    for (const bool gyro : {false, true})
      for (std::size_t i = 0; i < 3; ++i) {
        const auto* name = std::get_if<std::string>(&regressors->rows[r][0]);
        if (!name || *name != role(gyro, i) + "_scale_factor_error") continue;
        triad(c, gyro).range[i] =
            std::max(std::abs(reader.cell(*regressors, r, 1)), std::abs(reader.cell(*regressors, r, 2)));
      }
}

/// Claims the three axes of a triad, and says how its outputs are read.
TriadCalibration& begin_triad(Reader& reader, bool gyro, std::set<std::string>& claimed) {
  TriadCalibration& t = triad(reader.calibration(), gyro);
  for (std::size_t i = 0; i < 3; ++i)
    for (const char* part : {" bias", " scale factor"}) reader.claim(role(gyro, i) + part, claimed);
  t.calibrated = true;
  t.axes = {true, true, true};
  t.output = input_unit(gyro);
  const std::string nominal = gyro ? "gyro_scale_factor" : "accelerometer_scale_factor";
  if (const std::string text = reader.setting(nominal); !text.empty())
    t.reading = "the output over its nominal scale factor " + text;
  return t;
}

std::string misalignment(bool gyro, std::size_t i, std::size_t j) {
  return fmt::format("{}_misalignment_{}", role(gyro, i), letters[j]);
}

std::string sensitivity(std::size_t i, std::size_t j) {
  return fmt::format("{}_acceleration_sensitivity_{}", role(true, i), letters[j]);
}

/// One output of read_terms.
void read_axis(Reader& reader, bool gyro, std::size_t i, TriadCalibration& t) {
  const std::string name = role(gyro, i);
  const auto counted = reader.find(name + "_scale_factor");
  const double k = counted.value_or(1.0);
  if (counted) t.output = si_unit(find_parameter(reader.estimate(), name + "_bias")->unit);
  t.bias[i] = reader.value_or(name + "_bias", 0.0);
  t.response(i, i) = k * (1.0 + reader.value_or(name + "_scale_factor_error", 0.0));
  for (std::size_t j = 0; j < 3; ++j) {
    if (j != i) t.response(i, j) = k * reader.value_or(misalignment(gyro, i, j), 0.0);
    if (gyro) t.by_force(i, j) = k * reader.value_or(sensitivity(i, j), 0.0);
    if (!gyro) t.lever(i, j) = k * reader.value_or(fmt::format("{}_lever_{}", name, letters[j]), 0.0);
  }
  if (!gyro) t.curve[i].power[0] = k * reader.value_or(name + "_second_order_coefficient", 0.0);
}

/// Sign of the diagonal of R in row `i`, which no parameter states: -1 where the table `matrices` has it so.
double sign_of_diagonal(Reader& reader, bool gyro, std::size_t i) {
  const Table* table = find_table(reader.estimate(), "matrices");
  if (table == nullptr || table->columns.size() != 6) return 1.0;
  std::size_t row = 0;
  for (std::size_t r = 0; r < table->rows.size(); ++r) {
    const auto* of = std::get_if<std::string>(&table->rows[r][0]);
    if (of && *of == (gyro ? "R_g" : "R_a") && row++ == i) return reader.cell(*table, r, 3 + i) < 0.0 ? -1.0 : 1.0;
  }
  return 1.0;
}

}  // namespace

void read_terms(Reader& reader, std::set<std::string>& claimed) {
  for (const bool gyro : {false, true}) {
    if (!reader.has(role(gyro, 0) + "_bias")) continue;
    TriadCalibration& t = begin_triad(reader, gyro, claimed);
    for (std::size_t i = 0; i < 3; ++i) read_axis(reader, gyro, i, t);
  }
  set_ranges(reader);
}

void read_ferraris(Reader& reader, std::set<std::string>& claimed) {
  for (const bool gyro : {false, true}) {
    if (!reader.has(role(gyro, 0) + "_bias")) continue;
    TriadCalibration& t = begin_triad(reader, gyro, claimed);
    t.output = si_unit(find_parameter(reader.estimate(), role(gyro, 0) + "_bias")->unit);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string name = role(gyro, i);
      const double k = reader.value_or(name + "_scale_factor", 1.0);
      double others = 0.0;
      for (std::size_t j = 0; j < 3; ++j) {
        if (gyro) t.by_force(i, j) = reader.value_or(sensitivity(i, j), 0.0);
        if (j == i) continue;
        const double cosine = reader.value_or(misalignment(gyro, i, j), 0.0);
        t.response(i, j) = k * cosine;
        others += cosine * cosine;
      }
      t.response(i, i) = k * sign_of_diagonal(reader, gyro, i) * std::sqrt(std::max(1.0 - others, 0.0));
      t.bias[i] = reader.value_or(name + "_bias", 0.0);
    }
  }
  set_ranges(reader);
}

void read_channels(Reader& reader, std::set<std::string>& claimed) {
  for (const bool gyro : {false, true}) {
    if (!reader.has(role(gyro, 0) + "_bias")) continue;
    TriadCalibration& t = begin_triad(reader, gyro, claimed);
    Matrix3 m = identity3();
    Vector3 nabla;
    for (std::size_t i = 0; i < 3; ++i) {
      nabla[i] = reader.value_or(role(gyro, i) + "_bias", 0.0);
      m(i, i) += reader.value_or(role(gyro, i) + "_scale_factor_error", 0.0);
      for (std::size_t j = 0; j < 3; ++j)
        if (j != i) m(i, j) = reader.value_or(misalignment(gyro, i, j), 0.0);
    }
    t.response = inverse(m);
    t.bias = t.response * nabla;
  }
  set_ranges(reader);
}

}  // namespace tumble::results
