#include "tumble/station/lease.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "tumble/station/lease/claim.hpp"
#include "tumble/station/lease/names.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

struct NamedDevice {
  std::string name;
  const StationDevice* device;
};

/// All that the devices of a station are called on this machine, each name once.
std::vector<NamedDevice> names_of(const Station& station) {
  std::vector<NamedDevice> names;
  for (const StationDevice& device : station.devices)
    for (const std::string& name : lease::names_of_device(device))
      if (std::ranges::find(names, name, &NamedDevice::name) == names.end()) names.push_back({name, &device});
  return names;
}

Problem said_in_use(const StationDevice& device, const lease::Holder& holder) {
  if (holder.run.empty() && holder.process == 0)
    return say("{} at {} is in use by another process of this machine", Name{device.name}, Name{device.link});
  return say("{} at {} is in use by the run '{}' (process {}); tumble stop ends it", Name{device.name},
             Name{device.link}, holder.run, holder.process);
}

}  // namespace

struct Lease::Inner {
  std::vector<lease::Claim> claims;
};

Lease::Lease(const Station& station, const std::string& run) : inner_(std::make_unique<Inner>()) {
  Problems problems;
  for (const auto& [name, device] : names_of(station)) {
    lease::Claim claim(name);
    if (!claim.holds()) {
      if (const auto said = said_in_use(*device, claim.before()); std::ranges::find(problems, said) == problems.end())
        problems.push_back(said);
      continue;
    }
    const lease::Holder& before = claim.before();
    if (before.process != 0 && std::ranges::find(left_, before.run, &LeaseHolder::run) == left_.end())
      left_.push_back({before.process, before.run});
    inner_->claims.push_back(std::move(claim));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_file, problems);
  const std::string own = fmt::format("{} {}\n", getpid(), std::filesystem::absolute(run).lexically_normal().string());
  for (lease::Claim& claim : inner_->claims) claim.note(own);
}

Lease::~Lease() = default;

void Lease::end() {
  for (lease::Claim& claim : inner_->claims) claim.give_back();
}

std::vector<LeaseHolder> runs_going_on() {
  std::vector<LeaseHolder> runs;
  for (const lease::Holder& holder : lease::holders()) runs.push_back({holder.process, holder.run});
  return runs;
}

}  // namespace tumble
