#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/wire/controller.hpp"

namespace tumble {

/// A declaration of a controller that travels inside the program.
struct ShippedController {
  std::string_view name;  ///< of its file, without .toml
  std::string title;
  FrameCertainty certainty = FrameCertainty::uncertain;
  std::string_view text;  ///< TOML with comments
};

/// All shipped controllers by name.
const std::vector<ShippedController>& shipped_controllers();

/// The one of that name. Throws Error::unsupported with the nearest names.
const ShippedController& find_controller(const std::string& name);

/// The controller, with these settings in place of the defaults. Throws Error::bad_input for a setting that it lacks.
Controller controller_of(const ShippedController& shipped, const std::map<std::string, std::string>& settings = {});

}  // namespace tumble
