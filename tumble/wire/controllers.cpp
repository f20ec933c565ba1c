#include "tumble/wire/controllers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {

namespace assets {
extern const std::vector<std::pair<std::string_view, std::string_view>> controllers;
}

namespace {

std::vector<ShippedController> all_controllers() {
  std::vector<ShippedController> all;
  for (const auto& [name, text] : assets::controllers) {
    const Controller controller = read_controller(text, std::string(name) + ".toml");
    all.push_back({name, controller.title, controller.certainty, text});
  }
  std::ranges::sort(all, {}, &ShippedController::name);
  return all;
}

}  // namespace

const std::vector<ShippedController>& shipped_controllers() {
  static const std::vector<ShippedController> all = all_controllers();
  return all;
}

const ShippedController& find_controller(const std::string& name) {
  const auto& all = shipped_controllers();
  if (const auto found = std::ranges::find(all, name, &ShippedController::name); found != all.end()) return *found;
  std::vector<std::string> known;
  for (const auto& shipped : all) known.emplace_back(shipped.name);
  throw Error(Error::Kind::unsupported,
              say("there is no declaration of a controller '{}'{} (shipped are {}; a declaration of your own is "
                  "given by its file, which ends in .toml)",
                  name, did_you_mean(name, known), fmt::join(known, ", ")));
}

Controller controller_of(const ShippedController& shipped, const std::map<std::string, std::string>& settings) {
  Controller controller = read_controller(shipped.text, std::string(shipped.name) + ".toml", settings);
  controller.name = shipped.name;
  return controller;
}

}  // namespace tumble
