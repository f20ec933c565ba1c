#include "tumble/models/fiber_optic_gyro/coil.hpp"

#include <fmt/format.h>

#include <optional>

#include "tumble/models/fiber_optic_gyro/shupe.hpp"
#include "tumble/units/error.hpp"

namespace tumble::fiber_optic_gyro {
namespace {

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

void refuse_coil(const Settings& truth) {
  const int layers = truth.integer("layers");
  const std::string& winding = truth.word("winding");
  const int multiple = winding == "quadrupole" ? 4 : winding == "dipole" ? 2 : 1;
  if (layers % multiple != 0)
    throw Error(Error::Kind::bad_input,
                say("layers = {}, but a {} winding has a multiple of {}", layers, Name{winding}, multiple));
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
  return {
      word("winding", {"none", "plain", "dipole", "quadrupole"})
          .otherwise("none")
          .says("winding of the coil: heat flow through it causes drift, docs/equations (4.29); none: no such drift"),
      quantity("fibre_length", "m").above(0).otherwise("1000 m").says("L"),
      quantity("coil_diameter", "mm").above(0).otherwise("100 mm").says("D, mean"),
      quantity("refractive_index").above(0).otherwise("1.45").says("n of the core"),
      quantity("index_slope", "1/K").otherwise("1e-5 1/K").says("dn/dT"),
      quantity("fibre_expansion", "1/K").otherwise("5.5e-7 1/K").says("alpha, of the fibre's length"),
      integer("layers").between(1, 1000).otherwise("32").says(
          "layers of the winding: even for a dipole, a multiple of 4 for a quadrupole"),
      quantity("coil_thickness", "mm").above(0).otherwise("10 mm").says("thickness of all layers"),
      quantity("coil_diffusivity", "mm^2/s")
          .above(0)
          .otherwise("0.2 mm^2/s")
          .says("diffusivity of heat across the layers"),
      word("inner_face", {"insulated", "exposed"})
          .otherwise("insulated")
          .says("inner face of the coil; exposed: the gradient is the difference between its faces")};
}

History coil_drift(const Settings& truth, double step) {
  if (truth.word("winding") == "none") return nullptr;
  refuse_coil(truth);
  return Drift(coil_of(truth), step);
}

}  // namespace tumble::fiber_optic_gyro
