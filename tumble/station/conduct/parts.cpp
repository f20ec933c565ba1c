#include <filesystem>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/station/carry_out.hpp"
#include "tumble/station/link.hpp"
#include "tumble/units/error.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble {
namespace {

/// A file beside the station file.
std::string beside(const Station& station, const std::string& path) {
  const std::filesystem::path given(path);
  return given.is_absolute() ? path : (std::filesystem::path(station.file).parent_path() / given).string();
}

StationParts::Stream stream_of(const Station& station, const StationInstrument& instrument) {
  StationParts::Stream stream;
  if (instrument.frames.empty()) return stream;
  const InstrumentChoice choice = parse_instrument(instrument.frames);
  stream.variants = choice.variants;
  if (choice.name.ends_with(".toml")) {
    stream.name = beside(station, choice.name);
    stream.text = read_text_file(stream.name);
  } else {
    stream.name = choice.name;
    stream.text = find_instrument(choice.name).text;
  }
  stream.codec = read_frames(stream.text, stream.name, choice.variants);
  return stream;
}

/// A serial link with the rate and the framing of its declaration where it states none.
std::string with_declared_line(const std::string& link, long baud, const std::string& format) {
  if (!link.starts_with("serial:")) return link;
  LinkAddress address = parse_link(link);
  if (address.baud == 0) address.baud = baud;
  if (address.framing.empty()) address.framing = format;
  return text_of(address);
}

template <class Work>
void collect(std::vector<std::string>& problems, const std::string& what, Work work) {
  try {
    work();
  } catch (const Error& error) {
    for (const auto& problem : error.problems) problems.push_back(what + ": " + problem);
  }
}

}  // namespace

StationParts parts_of(Station& station) {
  StationParts parts;
  std::vector<std::string> problems;
  for (StationDevice& device : station.devices)
    collect(problems, device.name, [&] {
      parts.controllers.push_back(
          controller_of_device(device, std::filesystem::path(station.file).parent_path().string()));
      const ControllerLink& line = parts.controllers.back().link;
      device.link = with_declared_line(device.link, line.baud, line.format);
      const bool stated = !device.verbs.empty();  // the station may know better than the declaration
      for (const ControllerCommand& command : parts.controllers.back().commands) {
        device.takes[command.verb] = command.takes;
        if (stated) continue;
        device.verbs.push_back(command.verb);
        if (command.once) device.once.push_back(command.verb);
      }
    });
  for (StationInstrument& instrument : station.instruments)
    collect(problems, instrument.slot, [&] {
      const StationParts::Stream& stream = parts.streams.emplace_back(stream_of(station, instrument));
      instrument.link = with_declared_line(instrument.link, stream.codec.link.baud, stream.codec.link.format);
    });
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return parts;
}

}  // namespace tumble
