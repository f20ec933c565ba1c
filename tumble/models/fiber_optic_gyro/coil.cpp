#include "tumble/models/fiber_optic_gyro/coil.hpp"

#include <fmt/format.h>

#include <optional>

#include "tumble/models/fiber_optic_gyro/shupe.hpp"
#include "tumble/units/error.hpp"

namespace tumble::fiber_optic_gyro {
namespace {

using Type = Option::Type;

Coil coil_of(const Settings& truth) {
  const std::string& winding = truth.word("winding");
  return {.length = truth.number("fibre_length"),
          .diameter = truth.number("coil_diameter"),
          .index = truth.number("refractive_index"),
          .index_slope = truth.number("index_slope"),
          .expansion = truth.number("fibre_expansion"),
          .winding = winding == "plain"    ? Winding::plain
                     : winding == "dipole" ? Winding::dipole
                                           : Winding::quadrupole,
          .layers = truth.integer("layers"),
          .thickness = truth.number("coil_thickness"),
          .diffusivity = truth.number("coil_diffusivity"),
          .inner_insulated = truth.word("inner_face") == "insulated"};
}

void refuse(const Settings& truth) {
  std::vector<std::string> problems;
  for (const char* name : {"fibre_length", "coil_diameter", "refractive_index", "coil_thickness", "coil_diffusivity"})
    if (!(truth.number(name) > 0.0)) problems.push_back(fmt::format("{} must be positive", name));
  const int layers = truth.integer("layers");
  const std::string& winding = truth.word("winding");
  const int multiple = winding == "quadrupole" ? 4 : winding == "dipole" ? 2 : 1;
  if (layers < 1 || layers > 1000 || layers % multiple != 0)
    problems.push_back(fmt::format("layers = {}, but a {} winding has {}from {} to 1000", layers, winding,
                                   multiple == 1 ? "" : fmt::format("a multiple of {}, ", multiple), multiple));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// Faces of the coil at the end of each step, from what is felt at its middle.
class Drift {
 public:
  Drift(const Coil& coil, double step) : coil_(coil), step_(step) {}

  void operator()(std::span<const Felt> felt, std::span<double> samples) {
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const Felt& now = felt[k];
      const double half = 0.5 * now.temperature_rate * step_;
      if (!heat_) heat_.emplace(coil_, outer(now) - half, inner(now) - half);
      samples[k] += heat_->advance(step_, outer(now) + half, inner(now) + half);
    }
  }

 private:
  /// The gradient, top minus side, is the difference between the faces; an insulated coil has one face.
  double outer(const Felt& felt) const {
    return felt.temperature + (coil_.inner_insulated ? 0.0 : 0.5 * felt.temperature_gradient);
  }
  double inner(const Felt& felt) const { return felt.temperature - 0.5 * felt.temperature_gradient; }

  Coil coil_;
  double step_;
  std::optional<CoilHeat> heat_;
};

}  // namespace

std::vector<Option> coil_options() {
  return {{"winding",
           Type::word,
           "1",
           "none",
           {"none", "plain", "dipole", "quadrupole"},
           "winding of the coil: heat flow through it causes drift, docs/equations (4.29); none: no such drift"},
          {"fibre_length", Type::quantity, "m", "1000 m", {}, "L"},
          {"coil_diameter", Type::quantity, "mm", "100 mm", {}, "D, mean"},
          {"refractive_index", Type::quantity, "1", "1.45", {}, "n of the core"},
          {"index_slope", Type::quantity, "1/K", "1e-5 1/K", {}, "dn/dT"},
          {"fibre_expansion", Type::quantity, "1/K", "5.5e-7 1/K", {}, "alpha, of the fibre's length"},
          {"layers",
           Type::integer,
           "1",
           "32",
           {},
           "layers of the winding: even for a dipole, a multiple of 4 for a quadrupole"},
          {"coil_thickness", Type::quantity, "mm", "10 mm", {}, "thickness of all layers"},
          {"coil_diffusivity", Type::quantity, "mm^2/s", "0.2 mm^2/s", {}, "diffusivity of heat across the layers"},
          {"inner_face",
           Type::word,
           "1",
           "insulated",
           {"insulated", "exposed"},
           "inner face of the coil; exposed: the gradient is the difference between its faces"}};
}

History coil_drift(const Settings& truth, double step) {
  if (truth.word("winding") == "none") return nullptr;
  refuse(truth);
  return Drift(coil_of(truth), step);
}

}  // namespace tumble::fiber_optic_gyro
