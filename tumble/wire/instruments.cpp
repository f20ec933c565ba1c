#include "tumble/wire/instruments.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {

namespace assets {
extern const std::vector<std::pair<std::string_view, std::string_view>> instruments;
}

namespace {

std::vector<ShippedInstrument> all_instruments() {
  std::vector<ShippedInstrument> all;
  for (const auto& [name, text] : assets::instruments) {
    const FrameCodec codec = read_frames(text, std::string(name) + ".toml");
    all.push_back({name, codec.title, codec.certainty, codec.variants, text});
  }
  std::ranges::sort(all, {}, &ShippedInstrument::name);
  return all;
}

}  // namespace

const std::vector<ShippedInstrument>& shipped_instruments() {
  static const std::vector<ShippedInstrument> all = all_instruments();
  return all;
}

const ShippedInstrument& find_instrument(const std::string& name) {
  const auto& all = shipped_instruments();
  if (const auto found = std::ranges::find(all, name, &ShippedInstrument::name); found != all.end()) return *found;
  std::vector<std::string> known;
  for (const auto& instrument : all) known.emplace_back(instrument.name);
  throw Error(Error::Kind::unsupported,
              say("there is no declaration of frames '{}'{} (shipped are {}; a declaration of your own is given "
                  "by its file, which ends in .toml)",
                  name, did_you_mean(name, known), fmt::join(known, ", ")));
}

FrameCodec codec_of(const ShippedInstrument& instrument, const std::vector<std::string>& variants) {
  FrameCodec codec = read_frames(instrument.text, std::string(instrument.name) + ".toml", variants);
  codec.name = instrument.name;
  return codec;
}

InstrumentChoice parse_instrument(std::string_view text) {
  const auto toml = text.rfind(".toml");
  const auto colon = text.find(':', toml == std::string_view::npos ? 0 : toml);
  InstrumentChoice choice{std::string(text.substr(0, colon)), {}};
  if (colon == std::string_view::npos) return choice;
  for (auto rest = text.substr(colon + 1);;) {
    const auto comma = rest.find(',');
    if (const auto part = rest.substr(0, comma); !part.empty()) choice.variants.emplace_back(part);
    if (comma == std::string_view::npos) return choice;
    rest.remove_prefix(comma + 1);
  }
}

}  // namespace tumble
