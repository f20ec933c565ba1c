#include "tumble/rehearsal/virtual_rig.hpp"

#include "tumble/rehearsal/virtual_rig/bench.hpp"

namespace tumble {

struct VirtualRig::State {
  virtual_rig::Bench bench;
};

VirtualRig::VirtualRig(const Plan& plan, std::uint64_t seed, SampleTiming timing)
    : state_(new State{virtual_rig::Bench(plan, seed, timing)}) {}
VirtualRig::VirtualRig(const VirtualRig& other) : state_(std::make_unique<State>(*other.state_)) {}
VirtualRig::VirtualRig(VirtualRig&&) noexcept = default;
VirtualRig& VirtualRig::operator=(const VirtualRig& other) {
  if (this != &other) state_ = std::make_unique<State>(*other.state_);
  return *this;
}
VirtualRig& VirtualRig::operator=(VirtualRig&&) noexcept = default;
VirtualRig::~VirtualRig() = default;

std::vector<std::string> VirtualRig::axes() const {
  std::vector<std::string> names;
  for (const auto& axis : state_->bench.rig->axes()) names.push_back(axis.name);
  return names;
}

bool VirtualRig::is_temperature(const std::string& axis) const { return state_->bench.control(axis).is_air(); }

Refusal VirtualRig::command(double time, const std::string& axis, const Motion& motion) {
  return state_->bench.command(time, axis, motion);
}

Refusal VirtualRig::carry_out(double time, const Segment& segment) { return state_->bench.carry_out(time, segment); }

Refusal VirtualRig::stop(double time, const std::string& axis) {
  auto& bench = state_->bench;
  bench.advance(time);
  if (bench.control(axis).has(Trouble::refuses)) return axis + " refuses";
  bench.halt(time, axis);
  return {};
}

void VirtualRig::enable(double time, const std::string& axis, bool on) {
  auto& bench = state_->bench;
  bench.advance(time);
  if (bench.control(axis).enabled && !on) bench.halt(time, axis);
  bench.control(axis).enabled = on;
}

void VirtualRig::clear_fault(double time, const std::string& axis) {
  auto& bench = state_->bench;
  bench.advance(time);
  if (bench.control(axis).fault.empty()) return;
  bench.control(axis).fault.clear();
  bench.control(axis).enabled = true;
}

void VirtualRig::place(double time, const std::map<std::string, double>& values) { state_->bench.place(time, values); }
void VirtualRig::power(double time, bool on) { state_->bench.power(time, on); }
bool VirtualRig::obeys(const std::string& axis) const {
  const auto found = state_->bench.axes.find(axis);
  return found == state_->bench.axes.end() || !found->second.has(Trouble::stuck);
}

int VirtualRig::power_up() const { return state_->bench.on ? state_->bench.power_ups : 0; }
AxisReading VirtualRig::reading(double time, const std::string& axis) { return state_->bench.reading(time, axis); }

std::vector<VirtualSamples> VirtualRig::samples(double time, std::size_t most) {
  return state_->bench.samples(time, most);
}

void VirtualRig::begin(double time, const std::string& axis, Trouble trouble, double size) {
  state_->bench.begin(time, axis, trouble, size);
}

void VirtualRig::end(double time, const std::string& axis, Trouble trouble) { state_->bench.end(time, axis, trouble); }

const Plan& VirtualRig::plan() const { return *state_->bench.plan; }

}  // namespace tumble
