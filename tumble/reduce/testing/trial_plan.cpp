#include "tumble/reduce/testing/trial_plan.hpp"

#include <cmath>

#include "tumble/earth/earth.hpp"
#include "tumble/math/random.hpp"
#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble {

Plan trial_plan(const std::string& method, const std::vector<Option>& options, const std::string& model,
                const std::string& rig, double rate) {
  Plan plan;
  plan.method = method;
  plan.instrument_model = model;
  plan.sample_rate = rate;
  plan.site = Site{si(34.25, "deg"), si(108.9, "deg"), 400.0, {}};
  plan.site->gravity = gravity(*plan.site);  // as measured
  plan.rig_kind = rig;
  plan.rig = defaults(find_rig(rig).options());
  plan.settings = defaults(options);
  plan.truth = defaults(truth_options(find_model(model)));
  return plan;
}

void set_truth(Plan& plan, const char* name, double value, const char* unit) {
  plan.truth.set_number(name, si(value, unit), Unit::parse(unit));
}

void set_truth(Plan& plan, std::span<const TruthValue> values) {
  for (const auto& [name, value, unit] : values) set_truth(plan, name, value, unit);
}

void set_setting(Plan& plan, const char* name, double value, const char* unit) {
  plan.settings.set_number(name, si(value, unit), Unit::parse(unit));
}

void lose_samples(Recording& recording, std::uint64_t seed, std::uint64_t every) {
  const RandomStream random = RandomStream(seed).split("lost samples");
  for (auto& channel : recording.channels) {
    const std::size_t size = channel.values.size();
    for (std::size_t i = 0; i < size; ++i)
      if (random.uniform(i) * static_cast<double>(every) < 1.0 || (i >= size / 2 && i < size / 2 + 10))
        channel.values[i] = std::nan("");
  }
}

}  // namespace tumble
