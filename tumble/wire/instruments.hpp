#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tumble/wire/frames.hpp"

namespace tumble {

/// A declaration of frames that travels inside the program.
struct ShippedInstrument {
  std::string_view name;  ///< of its file, without .toml
  std::string title;
  FrameCertainty certainty = FrameCertainty::uncertain;
  std::vector<std::string> variants;
  std::string_view text;  ///< TOML with comments
};

/// All shipped instruments by name.
const std::vector<ShippedInstrument>& shipped_instruments();

/// The one of that name. Throws Error::unsupported with the nearest names.
const ShippedInstrument& find_instrument(const std::string& name);

/// The frames of an instrument, in these variants. Throws Error::bad_input for a variant that it does not have.
FrameCodec codec_of(const ShippedInstrument& instrument, const std::vector<std::string>& variants = {});

/// "kvh_1775:gyro_rate,temperature_hundredths"
struct InstrumentChoice {
  std::string name;  ///< of a shipped declaration, or a file that ends in .toml
  std::vector<std::string> variants;
};
InstrumentChoice parse_instrument(std::string_view text);

}  // namespace tumble
