#include "tumble/models/axes/axes.hpp"
#include "tumble/models/model.hpp"

namespace tumble::models::triad {
namespace {

std::vector<Option> constants() {
  auto options = axes::options(true, true);
  options.insert(
      options.begin(),
      word("sensors", {"accelerometers", "gyros"}).otherwise("accelerometers").says("what the three sensors measure"));
  return options;
}

std::vector<Output> outputs(const Settings& constants) {
  return constants.word("sensors") == "gyros" ? axes::gyros() : axes::accelerometers();
}

Recorded record(const Settings& truth, std::size_t output, double step, const RandomStream& random) {
  return axes::record(outputs(truth)[output], truth, step, random);
}

}  // namespace

extern const Model triad{
    .name = "triad",
    .summary = "three accelerometers or three gyros: bias, scale factor, misalignment, lever arms, noise",
    .source =
        "linear sensor models as in Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, "
        "2015; names of IEEE Std 528",
    .constants = constants,
    .outputs = outputs,
    .record = record};

}  // namespace tumble::models::triad
