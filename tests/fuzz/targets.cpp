#include "targets.hpp"

#include <algorithm>
#include <filesystem>

#include "readers.hpp"
#include "services.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/testing/example_estimate.hpp"
#include "tumble/tasks/ready_plans.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/wire/controllers.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble::fuzz {

namespace {

namespace fs = std::filesystem;

const Format* format_named(const std::string& name) {
  for (const Format* format : format_catalogue())
    if (name == format->name) return format;
  return nullptr;
}

/// Any stream is decoded, in pieces too, with the same result; its counts agree with its bytes.
std::string stream_through(const FrameCodec& codec, std::string_view bytes, std::size_t piece) {
  std::uint64_t frames[2] = {}, lost[2] = {};
  std::string wrong;
  for (int way = 0; way < 2; ++way) {
    FrameStream stream(codec);
    const auto sink = [&](const StreamFrame& frame) {
      for (const double value : frame.content.values)
        if (std::isinf(value)) wrong = "infinite value";
      if (frame.offset > bytes.size()) wrong = "a frame behind the end";
    };
    for (std::size_t at = 0; at < bytes.size(); at += way == 0 ? bytes.size() : piece)
      stream.feed(bytes.substr(at, way == 0 ? bytes.size() : piece), sink);
    stream.finish(sink);
    const FrameCounts& counts = stream.counts();
    if (counts.bytes != bytes.size() || counts.good_bytes + counts.skipped_bytes + counts.cut > bytes.size())
      wrong = "the counts of bytes are wrong";
    frames[way] = counts.channel_frames;
    lost[way] = counts.lost;
  }
  if (frames[0] != frames[1] || lost[0] != lost[1]) wrong = "pieces are decoded otherwise than the whole";
  return wrong.empty() ? "" : codec.name + ": " + wrong;
}

const std::vector<FrameCodec>& all_codecs() {
  static const std::vector<FrameCodec> codecs = [] {
    std::vector<FrameCodec> all;
    for (const auto& instrument : shipped_instruments()) all.push_back(codec_of(instrument));
    return all;
  }();
  return codecs;
}

std::string run_frame_stream(std::string_view bytes) {
  if (bytes.size() < 2) return "";
  const auto& codecs = all_codecs();
  const auto& codec = codecs[static_cast<unsigned char>(bytes[0]) % codecs.size()];
  return outcome([&] { return stream_through(codec, bytes.substr(2), 1 + static_cast<unsigned char>(bytes[1])); });
}

std::string run_declaration(std::string_view bytes) {
  return outcome(
      [&] {
        const FrameCodec codec = read_frames(bytes, "d.toml");
        std::string stream;
        for (const FrameVector& vector : codec.vectors) stream += vector.bytes;
        for (const FrameVector& vector : codec.vectors)
          stream += vector.bytes.substr(vector.bytes.size() / 2) + vector.bytes;
        return stream_through(codec, stream, 7);
      },
      Error::Kind::bad_input);
}

/// Any bytes to the host that asked for something, and to the device: a reply at most, and nothing infinite.
std::string talk_through(const Controller& controller, std::size_t choice, std::string_view bytes, std::size_t piece) {
  ControllerHost host(controller);
  ControllerDevice device(controller);
  const auto& command = controller.commands[choice % controller.commands.size()];
  ControllerRequest request{command.verb};
  for (const auto& name : command.requires_) request.values[name] = name == "temperature" ? 300.0 : 1.0;
  outcome([&] { return host.ask(request); }, Error::Kind::bad_input);
  std::size_t accepted = 0;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    for (const auto& reply : host.feed(bytes.substr(at, piece))) {
      accepted += reply.problem.empty() && reply.verb == command.verb ? 1 : 0;
      for (const auto& [name, value] : reply.values)
        if (!std::isfinite(value)) return controller.name + ": infinite value";
    }
    for (std::size_t n = device.feed(bytes.substr(at, piece)).size(); n > 0; --n)
      outcome([&] { return device.answer({ControllerVerb::read}), std::string(); }, Error::Kind::bad_input);
    device.output();
    host.next();
  }
  return accepted > 1 ? controller.name + ": more than one reply to one request" : "";
}

const std::vector<Controller>& all_controllers() {
  static const std::vector<Controller> controllers = [] {
    std::vector<Controller> all;
    for (const auto& shipped : shipped_controllers()) all.push_back(controller_of(shipped));
    return all;
  }();
  return controllers;
}

std::string run_controller_bytes(std::string_view bytes) {
  if (bytes.size() < 3) return "";
  const auto& all = all_controllers();
  const auto number = [&](std::size_t at) { return static_cast<std::size_t>(static_cast<unsigned char>(bytes[at])); };
  return outcome([&] { return talk_through(all[number(0) % all.size()], number(1), bytes.substr(3), 1 + number(2)); });
}

std::string run_controller(std::string_view bytes) {
  return outcome(
      [&] {
        const Controller controller = read_controller(bytes, "c.toml");
        std::string stream;
        for (const auto& vector : controller.vectors) {
          for (const auto& line : vector.sends) stream += line;
          for (const auto& line : vector.replies) stream += line;
        }
        return talk_through(controller, bytes.size(), stream, 7);
      },
      Error::Kind::bad_input);
}

/// Errors of a plan are bad_input, or bad_file where a file that it names cannot be read.
std::string run_plan(std::string_view bytes, const std::string& path) {
  write_bytes(bytes, path);
  const auto load = [&] { return load_plan(path, {}), std::string(); };
  const auto wrong = outcome(load, Error::Kind::bad_input);
  return wrong.empty()                                  ? ""
         : outcome(load, Error::Kind::bad_file).empty() ? ""
                                                        : outcome(load, Error::Kind::unsupported);
}

/// A result that can be read can be written, as JSON and as a page; no drawing of it has a coordinate that is none.
std::string read_and_show(std::string_view bytes) {
  const Estimate estimate = estimate_from_json(std::string(bytes), "r.json");
  to_json(estimate), to_html(estimate), to_text(estimate);
  for (const Figure& figure : figures_of(estimate)) {
    std::string svg = to_svg(figure);
    for (std::size_t at = 0; (at = svg.find(" d=\"", at)) != svg.npos;) {
      const auto end = svg.find('"', at + 4);
      const auto path = std::string_view(svg).substr(at, end - at);
      if (path.find("nan") != path.npos || path.find("inf") != path.npos)
        return "a drawing has the path" + std::string(path);
      at = end;
    }
  }
  return "";
}

void add_small_files(const fs::path& folder, std::vector<fs::path>& files) {
  if (!fs::exists(folder)) return;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.file_size() > 0 && entry.file_size() < 100'000) files.push_back(entry.path());
  std::ranges::sort(files);
}

bool belongs_to(const Format& format, const fs::path& file) {
  return std::ranges::find(format.extensions, file.extension().string()) != format.extensions.end() ||
         outcome([&] { return format.recognises(file.string()) ? "yes" : ""; }) == "yes";
}

/// A small recording, for formats that are written too.
Recording small_recording() {
  Recording recording;
  recording.channels = {
      {"gyro.x", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, 100.0, nullptr}, {1, 2, 3, 4}}};
  recording.marks = {{"static", 0.0, 1}};
  return recording;
}

}  // namespace

std::vector<std::string> target_names() {
  std::vector<std::string> names;
  for (const Format* format : format_catalogue()) names.emplace_back(format->name);
  for (const char* name : {"archive", "controller", "controller_bytes", "declaration", "frame_stream", "plan", "result",
                           "route", "station"})
    names.emplace_back(name);
  return names;
}

std::string run_target(const std::string& name, std::string_view bytes, const std::string& path) {
  if (const Format* format = format_named(name)) {
    write_bytes(bytes, path);
    return read_hostile_as(*format, path, some_options(bytes.size()));
  }
  if (name == "archive") return run_archive(bytes, path);
  if (name == "route") return run_route(bytes);
  if (name == "station") return run_station(bytes);
  if (name == "controller") return run_controller(bytes);
  if (name == "controller_bytes") return run_controller_bytes(bytes);
  if (name == "declaration") return run_declaration(bytes);
  if (name == "frame_stream") return run_frame_stream(bytes);
  if (name == "plan") return run_plan(bytes, path);
  if (name == "result") return outcome([&] { return read_and_show(bytes); });
  return "there is no target " + name;
}

std::vector<std::string> seeds_of(const std::string& name, const std::string& root, const std::string& path) {
  std::vector<std::string> seeds;
  std::vector<fs::path> files;
  const Format* const format = format_named(name);
  if (format && format->writer) {
    const std::string file = path + format->extensions.front();
    write_recording(small_recording(), file);
    seeds.push_back(read_text_file(file));
  }
  if (format) {
    add_small_files(fs::path(root) / "tests/reference", files);
    add_small_files(fs::path(root) / "examples", files);
    std::erase_if(files, [&](const fs::path& file) { return !belongs_to(*format, file); });
  }
  if (name == "declaration") add_small_files(fs::path(root) / "instruments", files);
  if (name == "controller") add_small_files(fs::path(root) / "controllers", files);
  if (name == "plan") add_small_files(fs::path(root) / "plans", files);
  if (name == "station") add_small_files(fs::path(root) / "stations", files);
  if (name == "route") return seeds_of_routes();
  if (name == "archive") return seeds_of_archives(path);
  if (name == "result") {
    add_small_files(fs::path(root) / "tests", files);
    std::erase_if(files, [](const fs::path& file) { return file.extension() != ".json"; });
    seeds.emplace_back(R"({"format": 1})");
    seeds.push_back(to_json(testing::estimate()));
  }
  for (const fs::path& file : files) seeds.push_back(read_text_file(file.string()));
  for (std::size_t i = 0; i < all_controllers().size() && name == "controller_bytes"; ++i) {
    const Controller& controller = all_controllers()[i];
    for (const auto& vector : controller.vectors) {
      const auto command = controller.find(vector.request.verb) - controller.commands.data();
      std::string seed{static_cast<char>(i), static_cast<char>(command), '\x07'};
      for (const auto& line : vector.replies) seed += line;
      for (const auto& line : vector.sends) seed += line;
      seeds.push_back(seed);
    }
  }
  for (std::size_t i = 0; i < all_codecs().size() && (name == "frame_stream" || name == "frames"); ++i) {
    std::string seed = name == "frames" ? "" : std::string{static_cast<char>(i), '\x07'};
    for (int times = 0; times < 3; ++times)
      for (const FrameVector& vector : all_codecs()[i].vectors) seed += vector.bytes;
    seeds.push_back(seed);
  }
  return seeds;
}

}  // namespace tumble::fuzz
