#include "tumble/station/recorder_session.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <optional>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/station/conduct/stream_line.hpp"
#include "tumble/units/error.hpp"
#include "tumble/version.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble {

namespace fs = std::filesystem;

namespace {

constexpr double look_interval = 0.1;  // s between two looks at the world
constexpr double answer_within = 2.0;  // s

/// The declaration of an instrument: its text, for the store, and its codec.
struct DeclaredInstrument {
  StoreLink link;
  FrameCodec codec;
};

DeclaredInstrument instrument_to_record(const RecordRequest& request) {
  const InstrumentChoice choice = parse_instrument(request.instrument);
  const bool own = fs::path(choice.name).extension() == ".toml";
  DeclaredInstrument instrument;
  instrument.link = {text_of(request.link),
                     {},
                     own ? read_text_file(choice.name) : std::string(find_instrument(choice.name).text),
                     choice.name,
                     choice.variants};
  instrument.codec =
      read_frames(instrument.link.declaration, own ? choice.name : choice.name + ".toml", choice.variants);
  instrument.codec.name = choice.name;
  if (!instrument.codec.unchosen.empty())
    throw Error(Error::Kind::bad_input,
                say("the frames of {} do not say what their numbers mean ({}); name the variant of the device, "
                    "for example {}:{} (variants: {})",
                    Name{choice.name}, fmt::join(instrument.codec.unchosen, ", "), Name{choice.name},
                    Name{instrument.codec.variants.front()}, fmt::join(instrument.codec.variants, ", ")));
  return instrument;
}

/// Who only listens cannot start the stream.
void check_start(const RecordRequest& request, const FrameLink& declared) {
  if (!request.start || declared.start.empty() || request.link.kind != LinkAddress::Kind::udp) return;
  if (!request.link.host.empty()) return;
  throw Error(Error::Kind::bad_input,
              say("'{}' only listens, and {} is started by commands; give its address, udp:HOST:{}, or use "
                  "--no-start for an instrument that streams already",
                  text_of(request.link), Name{request.instrument}, request.link.port));
}

LinkAddress with_declared_line(LinkAddress address, const FrameLink& declared) {
  if (address.kind != LinkAddress::Kind::serial) return address;
  if (address.baud == 0) address.baud = declared.baud;
  if (address.framing.empty()) address.framing = declared.format.empty() ? "8N1" : declared.format;
  if (address.baud == 0)
    throw Error(Error::Kind::bad_input,
                say("'{}': the declaration has no rate of the line; give it, for example {}:115200", text_of(address),
                    Name{"serial:" + address.device}));
  return address;
}

void check_output_is_free(const RecordRequest& request, const std::string& folder) {
  if (fs::exists(request.output))
    throw Error(
        Error::Kind::bad_file,
        say("'{}' is there already; a recording does not replace another: choose another name", request.output));
  if (fs::exists(fs::path(folder) / live_store_name))
    throw Error(Error::Kind::bad_file,
                say("'{}' holds a recording that was not sealed; `tumble seal {}` makes '{}' of it", folder,
                    Name{folder}, request.output));
}

/// A recording while it runs.
class Session {
 public:
  Session(const RecordRequest& request, const RecordWorld& world)
      : request_(request),
        world_(world),
        instrument_(instrument_to_record(request)),
        folder_(store_folder_of(request.output)),
        begin_(world.clock()),
        links_([this] { return now(); }),
        line_(
            instrument_.codec.link, [this](std::string_view bytes) { send(bytes); }, answer_within),
        disk_(world.disk ? *world.disk : own_disk_) {}

  RecordOutcome run() {
    check_start(request_, instrument_.codec.link);
    check_output_is_free(request_, folder_);
    const LinkAddress address = with_declared_line(request_.link, instrument_.codec.link);
    link_ = links_.open(address, 5.0, request_.silence);
    open_store();
    outcome_.ending = "complete";
    if (request_.start) start_or_remove();
    receive_until_end();
    if (request_.start) stop();
    return sealed();
  }

 private:
  double now() const { return world_.clock() - begin_; }

  void open_store() {
    std::error_code refused;
    const bool made = fs::create_directory(folder_, refused);
    if (refused)
      throw Error(Error::Kind::bad_file, say("cannot make the folder '{}': {}", folder_, system_reason(refused)));
    try {
      RecorderOptions options;
      options.clock = world_.clock;
      options.view = true;
      recorder_.emplace(folder_, disk_, options);
    } catch (const Error&) {
      std::error_code ignored;
      if (made) fs::remove_all(folder_, ignored);
      throw;
    }
    recorder_->set("target", (fs::path("..") / fs::path(request_.output).filename()).string());
    recorder_->set("frames", instrument_.codec.name);
    recorder_->set("link", instrument_.link.name);
    recorder_->set("program", std::string("tumble ") + version);
    note_wall_clock();
    stream_.emplace(*recorder_, instrument_.codec, instrument_.link);
  }

  /// The time of day beside that of the recording, once a minute.
  void note_wall_clock() {
    recorder_->event({now(), EventKind::clock, {}, say("{}", Name{world_.wall()}), {}});
    next_wall_clock_ = now() + 60.0;
  }

  /// Takes what has arrived. False: the recording has to end.
  bool receive(double seconds) {
    for (const LinkEvent& event : links_.wait(seconds)) {
      if (event.kind == LinkEvent::Kind::bytes) {
        stream_->receive(event.time, event.bytes);
        line_.receive(event.bytes, false, event.time);
      }
      received_ += event.bytes.size();
      if (event.kind != LinkEvent::Kind::lost) continue;
      recorder_->event({event.time, EventKind::link_lost, instrument_.link.name, event.reason, {}});
      end(say("the link was lost: {}", event.reason));
    }
    if (const auto failure = recorder_->failure()) end(failure->text);
    return outcome_.whole;
  }

  void end(const Sentence& reason) {
    if (!outcome_.whole) return;
    outcome_.whole = false;
    outcome_.ending = reason;
  }

  void send(std::string_view bytes) {
    stream_->sent(now(), bytes);
    links_.send(link_, bytes);
  }

  /// Of an instrument that does not start there is nothing to keep.
  void start_or_remove() {
    try {
      start();
    } catch (const Error&) {
      close();
      recorder_.reset();
      std::error_code ignored;
      fs::remove_all(folder_, ignored);
      throw;
    }
  }

  void start() {
    line_.start(now());
    while (!line_.answered()) {
      if (world_.ended() || !receive(look_interval)) return;
      if (line_.answered() || now() <= line_.next()) continue;
      throw Error(Error::Kind::bad_data,
                  say("{}: {}; compare the declaration and the rate of the line, or use --no-start for an "
                      "instrument that streams already",
                      Name{instrument_.link.name}, line_.at(now())));
    }
  }

  /// There is nothing to seal. Bytes that are no frames may still tell a person what the device sends.
  [[noreturn]] void refuse_empty() {
    recorder_.reset();
    std::error_code ignored;
    if (received_ == 0) fs::remove_all(folder_, ignored);
    const std::string& link = instrument_.link.name;
    if (received_ == 0)
      throw Error(Error::Kind::bad_data,
                  say("{}: {}", Name{link}, outcome_.whole ? Sentence("nothing was received") : outcome_.ending));
    Problems problems;
    if (!outcome_.whole) problems.push_back(outcome_.ending);
    problems.push_back(
        say("{}: no frame of {} was found in {} bytes; compare the declaration and the rate of the "
            "line (the bytes: `tumble seal {} --raw FILE.raw`)",
            Name{link}, Name{instrument_.codec.name}, received_, Name{folder_}));
    throw Error(Error::Kind::bad_data, problems);
  }

  void receive_until_end() {
    const double until = request_.duration > 0.0 ? now() + request_.duration : 0.0;
    while (receive(until > 0.0 ? std::min(look_interval, std::max(until - now(), 0.0)) : look_interval)) {
      if (now() > next_wall_clock_) note_wall_clock();
      if (world_.show) world_.show({now(), recorder_->acknowledged().time, &*stream_, recorder_->load()});
      if (world_.ended() || (until > 0.0 && now() >= until)) return;
    }
  }

  void stop() {
    line_.stop();
    const double until = now() + 0.5;
    while (links_.unsent(link_) > 0 && now() < until) receive(0.01);
  }

  void close() {
    stream_->finish();
    recorder_->close(now(), outcome_.ending);
    links_.close(link_);
  }

  RecordOutcome sealed() {
    close();
    recorder_.reset();  // of a disk that failed, the store is open still
    if (world_.sealing) world_.sealing();
    outcome_.store = folder_;
    if (stream_->counts().channel_frames == 0) refuse_empty();
    Disk disk;  // the one of the recording may have failed
    auto files = [&] {
      try {
        return seal(folder_, disk);
      } catch (const Error& error) {
        Problems problems = error.problems;
        problems.insert(problems.begin(),
                        outcome_.whole ? Problem("the recording cannot be sealed") : Problem(outcome_.ending));
        problems.push_back(say("what was recorded is kept in '{}'; `tumble seal {}` seals it", folder_, Name{folder_}));
        throw Error(error.kind, problems);
      }
    }();
    outcome_.sealed = std::move(files.at(0));
    if (request_.keep || !outcome_.whole) return outcome_;
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    outcome_.store.clear();
    return outcome_;
  }

  const RecordRequest& request_;
  const RecordWorld& world_;
  DeclaredInstrument instrument_;
  std::string folder_;
  double begin_;
  Links links_;
  conduct::StreamLine line_;
  std::size_t link_ = 0;
  Disk own_disk_;
  Disk& disk_;
  std::optional<Recorder> recorder_;
  std::optional<InstrumentRecorder> stream_;
  double next_wall_clock_ = 0.0;
  std::uint64_t received_ = 0;  // bytes
  RecordOutcome outcome_;
};

}  // namespace

std::string store_folder_of(const std::string& output) { return fs::path(output).replace_extension(".run").string(); }

RecordOutcome record(const RecordRequest& request, const RecordWorld& world) { return Session(request, world).run(); }

}  // namespace tumble
