#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/confinement.hpp"
#include "tumble/station/carry_out.hpp"
#include "tumble/station/link.hpp"
#include "tumble/units/error.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble {
namespace {

/// A file beside the station file.
std::string beside(const Station& station, const std::string& path) {
  return file_named_in(std::filesystem::path(station.file).parent_path(), path);
}

StationParts::Stream stream_of(const Station& station, const StationInstrument& instrument) {
  StationParts::Stream stream;
  if (instrument.frames.empty()) return stream;
  const InstrumentChoice choice = parse_instrument(instrument.frames);
  stream.variants = choice.variants;
  if (std::filesystem::path(choice.name).extension() == ".toml") {
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

/// How the controller reads back the temperature that was set, where the station lets it.
void note_read_back(StationDevice& device, const Controller& controller) {
  const ControllerCommand* const set = controller.find(ControllerVerb::set_temperature);
  if (!set || !set->read_back || (!device.verbs.empty() && !device.can(*set->read_back))) return;
  const ControllerCommand* const read = controller.find(*set->read_back);
  if (!read || std::ranges::find(read->gives, "set_point") == read->gives.end()) return;
  constexpr double room = 293.15;  // [K]
  device.set_point_verb = set->read_back;
  device.set_point_step = 2.0 * (resolution_of(controller, ControllerVerb::set_temperature, "temperature", room) +
                                 resolution_of(controller, *set->read_back, "set_point", room));
}

/// Whether the controller can say that it is off.
bool says_off(const Controller& controller) {
  const auto words = controller.words.find("state");
  if (words != controller.words.end())
    return std::ranges::find(words->second, "off", &ControllerWords::value_type::second) != words->second.end();
  return std::ranges::any_of(controller.bits, [](const ControllerBits& bits) {
    return bits.word == "state" && std::ranges::find(bits.rules, "off", &ControllerBitRule::means) != bits.rules.end();
  });
}

/// A device that is switched off by the safe list is asked whether it is: its acknowledgement alone is no proof.
void confirm_by_state(Station& station, const StationDevice& device, const Controller& controller) {
  if (!controller.find(ControllerVerb::state) || (!device.verbs.empty() && !device.can(ControllerVerb::state)) ||
      !says_off(controller))
    return;
  for (SafeCommand& command : station.safe) {
    const bool mine = &station.devices[command.device] == &device;
    if (!mine || command.request.verb != ControllerVerb::off || command.confirm) continue;
    Requirement off;
    off.text = device.name + ".state == off";
    off.terms = {
        {.channel = device.name + ".state", .compare = Requirement::Compare::equal, .right = std::string("off")}};
    off.steps = {{Requirement::Step::Kind::term, 0}};
    command.confirm = std::move(off);
  }
}

template <class Work>
void collect(Problems& problems, const std::string& what, Work work) {
  try {
    work();
  } catch (const Error& error) {
    for (const auto& problem : error.problems) problems.push_back(within(say("{}", Name{what}), problem));
  }
}

}  // namespace

StationParts parts_of(Station& station) {
  StationParts parts;
  Problems problems;
  for (StationDevice& device : station.devices)
    collect(problems, device.name, [&] {
      parts.controllers.push_back(
          controller_of_device(device, std::filesystem::path(station.file).parent_path().string()));
      const ControllerLink& line = parts.controllers.back().link;
      device.link = with_declared_line(device.link, line.baud, line.format);
      const bool stated = !device.verbs.empty();  // the station may know better than the declaration
      note_read_back(device, parts.controllers.back());
      confirm_by_state(station, device, parts.controllers.back());
      for (const ControllerCommand& command : parts.controllers.back().commands) {
        device.takes[command.verb] = command.takes;
        device.needs[command.verb] = command.requires_;
        if (stated) continue;
        device.verbs.push_back(command.verb);
        if (command.once) device.once.push_back(command.verb);
      }
    });
  for (StationInstrument& instrument : station.instruments)
    collect(problems, instrument.slot, [&] {
      const StationParts::Stream& stream = parts.streams.emplace_back(stream_of(station, instrument));
      const FrameLink& line = stream.codec.link;
      instrument.link = with_declared_line(instrument.link, line.baud, line.format);
      instrument.start = instrument.start && !(line.start.empty() && line.stop.empty());
      const bool listens = instrument.link.starts_with("udp:") && parse_link(instrument.link).host.empty();
      if (instrument.start && listens)
        throw Error(Error::Kind::bad_input,
                    say("'{}' only listens, and {} is started by commands; give its address, udp:HOST:PORT, or "
                        "start = false for an instrument that streams already",
                        instrument.link, Name{instrument.frames}));
    });
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return parts;
}

}  // namespace tumble
