#include "tumble/models/axes/axes.hpp"
#include "tumble/models/model.hpp"

namespace tumble::models::imu {
namespace {

std::vector<Option> constants() { return axes::options(true, true); }

std::vector<Output> outputs(const Settings&) {
  auto all = axes::gyros();
  for (auto& output : axes::accelerometers()) all.push_back(std::move(output));
  return all;
}

Recorded record(const Settings& truth, std::size_t output, double step, const RandomStream& random) {
  return axes::record(outputs(truth)[output], truth, step, random);
}

}  // namespace

extern const Model imu{
    .name = "imu",
    .summary =
        "three gyros and three accelerometers: bias, scale factor, misalignment, g-sensitivity, lever "
        "arms, noise",
    .source =
        "linear sensor models as in Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, "
        "2015; names of IEEE Std 528",
    .constants = constants,
    .outputs = outputs,
    .record = record};

}  // namespace tumble::models::imu
