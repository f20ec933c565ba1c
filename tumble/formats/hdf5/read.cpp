#include "tumble/formats/hdf5/read.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "tumble/core/instant.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/file/annotations.hpp"
#include "tumble/formats/file/budget.hpp"
#include "tumble/formats/file/even_clock.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/file/shares.hpp"
#include "tumble/formats/hdf5/values.hpp"
#include "tumble/math/room.hpp"
#include "tumble/units/error.hpp"

namespace tumble::hdf5 {

namespace {

/// What to do with uneven stamps: keep them, read them again with each block, or not even look at clocks.
enum class Stamps { kept, by_block, ignored };

/// Opens the file and every wanted channel in it, and finds their clocks. What is wrong is said all at once.
class Source {
 public:
  Source(const std::string& path, const ReadOptions& options, Stamps stamps)
      : path_(path),
        options_(options),
        stamps_(stamps),
        size_(file::InputFile(path).size()),
        budget_(size_, file::Budget::deflate_packing) {
    file_ = Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (!file_.valid()) refuse(say("cannot be opened as HDF5: {} (is it truncated or damaged?)", last_reason()));
    if (!options.segment_column.empty())
      refuse("is HDF5, whose marks say where segments begin: segment_column is for text tables");
    recording_.origin.file = path;
    for (const std::string& name : names()) open(name);
    if (!problems_.empty()) {
      problems_.front() = within(Where{.file = path, .place = say("'{}'", Name{path})}, problems_.front());
      throw Error{Error::Kind::bad_file, problems_};
    }
    if (channels_.empty()) refuse("has no channel to read in its group /channels");
    if (const auto text = meta()) read_meta(*text);
    if (const auto start = text_attribute(file_, clock_start)) recording_.meta.emplace(clock_start, *start);
  }

  std::optional<std::string> meta() const try { return text_dataset(file_, "/meta"); } catch (const Error& error) {
    refuse(say("cannot be read: /meta: {}", reason_of(error)));
  }

  void read_meta(const std::string& text) {
    const auto before = recording_.marks.size();
    if (file::annotate_all(recording_, text) &&
        (recording_.marks.size() > before || !recording_.meta.contains("marks")))
      return;
    recording_.findings.push_back({Finding::Severity::warning, "foreign_meta", {}, "/meta"});
  }

  /// The channels without samples.
  const Recording& frame() const { return recording_; }
  std::size_t samples(std::size_t channel) const { return channels_[channel].count; }

  void append(std::size_t channel, std::size_t first, std::size_t count, Channel& to) {
    try {
      hdf5::append(channels_[channel], first, count, to.unit.factor(), to.unit.offset(), to.values);
    } catch (const Error& error) {
      refuse(say("channel '{}' cannot be read: {}", to.name, reason_of(error)));
    }
  }

  /// The part of a channel's timeline that belongs to samples first .. first + count - 1.
  Timeline times(std::size_t channel, std::size_t first, std::size_t count) {
    const Timeline& whole = recording_.channels[channel].timeline;
    if (whole.uniform()) return {whole.time(first), whole.rate, nullptr};
    const auto of = std::find_if(clocks_.begin(), clocks_.end(),
                                 [&](const FileClock& clock) { return clock.timeline.stamps == whole.stamps; });
    std::vector<double> stamps;
    hdf5::append(of->numbers, first, count, of->unit.factor(), of->unit.offset(), stamps);
    return {0.0, 0.0, std::make_shared<const std::vector<double>>(std::move(stamps))};
  }

 private:
  [[noreturn]] void refuse(const Sentence& what) const {
    throw Error{Error::Kind::bad_file, say("'{}' {}", path_, what)};
  }

  /// Datasets below /channels, in the order they were made where the file knows it, and links to others of the file. What
  /// links to another file, or to no dataset, is refused when it is opened.
  std::vector<std::string> names() {
    if (!exists(file_, "/channels")) refuse("has no group /channels with one dataset for each channel");
    const Handle group(H5Gopen2(file_, "/channels", H5P_DEFAULT), H5Gclose);
    if (!group.valid()) refuse(say("cannot be read: /channels: {}", last_reason()));
    const Handle plist(H5Gget_create_plist(group), H5Pclose);
    unsigned order = 0;
    H5Pget_link_creation_order(plist, &order);
    std::vector<std::string> found;
    const auto visit = [](hid_t at, const char* name, const H5L_info_t* link, void* list) -> herr_t {
      H5O_info_t object;
      if (link->type != H5L_TYPE_HARD) {
        static_cast<std::vector<std::string>*>(list)->emplace_back(name);
        return 0;
      }
      if (H5Oget_info_by_name1(at, name, &object, H5P_DEFAULT) < 0) return -1;
      if (object.type == H5O_TYPE_DATASET) static_cast<std::vector<std::string>*>(list)->emplace_back(name);
      return 0;
    };
    const auto index = (order & H5P_CRT_ORDER_TRACKED) != 0 ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME;
    if (H5Lvisit(group, index, H5_ITER_INC, visit, &found) < 0)
      refuse(say("cannot be read: /channels: {}", last_reason()));
    return found;
  }

  void open(const std::string& name) {
    const auto& only = options_.only;
    if (!only.empty() && std::find(only.begin(), only.end(), name) == only.end()) return;
    try {
      budget_.take_text(name.size());
      Numbers numbers = open_numbers(file_, "/channels/" + name, size_);
      budget_.take_numbers(numbers.count, 1);  // many links to one dataset are as many channels
      Channel channel{name, QuantityKind::other, unit_of(numbers.dataset, name), {}, {}};
      channel.kind = kind_of(channel.unit);
      if (const auto word = text_attribute(numbers.dataset, "quantity")) file::kind_named(*word, channel.kind);
      channel.timeline = timeline_of(numbers, name);
      recording_.channels.push_back(std::move(channel));
      channels_.push_back(std::move(numbers));
    } catch (const Error& error) {
      problems_.push_back(say("channel '{}': {}", name, reason_of(error)));
    }
  }

  Unit unit_of(hid_t dataset, const std::string& name) const {
    if (const auto text = text_attribute(dataset, "unit"); text && !text->empty()) return Unit::parse(*text);
    const auto given = options_.units.find(name);
    if (given != options_.units.end()) return given->second;
    fail(
        say("it has no unit; give it an attribute 'unit', for example \"deg/h\", or write the unit in the plan's "
            "[channels] table: role = \"{}[deg/h]\", or give it: --set unit.{}=deg/h",
            Name{name}, Name{name}));
  }

  Timeline timeline_of(const Numbers& numbers, const std::string& name) {
    if (exists(file_, "/time/" + name)) return stamps_of(numbers, "/time/" + name);
    const auto rate = number_attribute(numbers.dataset, "rate");
    const double start = number_attribute(numbers.dataset, "start").value_or(0.0);
    if (!std::isfinite(start)) fail("its attribute 'start' is not a finite number");
    if (!rate && options_.rate) return {start, *options_.rate, nullptr};
    if (!rate)
      fail(
          say("it has no time; give it an attribute 'rate' [Hz] or a dataset /time/{}, or give the sampling rate "
              "(--set rate=100)",
              Name{name}));
    if (!(*rate > 0.0) || std::isinf(*rate)) fail("its attribute 'rate' is not a positive number");
    return {start, *rate, nullptr};
  }

  /// Channels that link to one dataset share its stamps.
  Timeline stamps_of(const Numbers& numbers, const std::string& path) {
    if (stamps_ == Stamps::ignored) return {};
    Numbers time = open_numbers(file_, path, size_);
    if (time.count != numbers.count)
      fail(say("{} has {} stamps for {} samples", Name{path}, time.count, numbers.count));
    H5O_info_t info;
    if (H5Oget_info1(time.dataset, &info) < 0) fail(last_reason());
    for (const auto& known : clocks_)
      if (known.address == info.addr) return known.timeline;
    budget_.take_numbers(time.count, 1);
    const Unit unit = Unit::parse(text_attribute(time.dataset, "unit").value_or("s"));
    if (kind_of(unit) != QuantityKind::time)
      fail(say("{} is in {}, not a unit of time", Name{path}, Name{unit.text()}));
    clocks_.push_back({info.addr, {}, std::move(time), unit});
    clocks_.back().timeline = look_at(clocks_.back(), path);
    return clocks_.back().timeline;
  }

  struct FileClock {
    haddr_t address;
    Timeline timeline;
    Numbers numbers;
    Unit unit;
  };

  /// Piece by piece: an even clock needs no stamps in memory.
  Timeline look_at(const FileClock& of, const std::string& path) {
    constexpr hsize_t piece = 65536;
    file::EvenClock clock;
    std::vector<double> stamps, some;
    if (stamps_ == Stamps::kept) stamps.reserve(of.numbers.count);
    for (hsize_t first = 0; first < of.numbers.count; first += piece) {
      some.clear();
      hdf5::append(of.numbers, first, std::min(piece, of.numbers.count - first), of.unit.factor(), of.unit.offset(),
                   some);
      for (std::size_t i = 0; i < some.size(); ++i) {
        if (std::isnan(some[i])) fail(say("{} has no value at sample {}", Name{path}, first + i));
        clock.add(some[i], 0.0);
      }
      if (stamps_ == Stamps::kept) stamps.insert(stamps.end(), some.begin(), some.end());
    }
    if (const auto even = clock.timeline(options_.rate)) return *even;
    return {0.0, 0.0, std::make_shared<const std::vector<double>>(std::move(stamps))};
  }

  std::string path_;
  const ReadOptions& options_;
  Stamps stamps_;
  std::size_t size_;
  file::Budget budget_;
  Handle file_;
  std::vector<Numbers> channels_;
  Recording recording_;
  std::vector<FileClock> clocks_;
  Problems problems_;
};

}  // namespace

Recording read(const std::string& path, const ReadOptions& options, const Progress& progress) {
  const Session session;
  Source source(path, options, Stamps::kept);
  Recording recording = source.frame();
  recording.origin.checksum = sha256_in_background(path);
  const std::size_t count = recording.channels.size();
  for (std::size_t i = 0; i < count; ++i) {
    Channel& channel = recording.channels[i];
    report(progress, static_cast<double>(i) / static_cast<double>(count), "reading");
    make_room(channel.values, source.samples(i));
    source.append(i, 0, source.samples(i), channel);
  }
  return recording;
}

std::uintmax_t memory(const std::string& path, const ReadOptions& options) {
  const Session session;
  const Source source(path, options, Stamps::ignored);
  std::uintmax_t samples = 0;
  for (std::size_t i = 0; i < source.frame().channels.size(); ++i) samples += source.samples(i);
  return sizeof(double) * samples;
}

void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  const Session session;
  Source source(path, options, Stamps::by_block);
  Recording block = source.frame();
  std::size_t longest = 0;
  for (std::size_t i = 0; i < block.channels.size(); ++i) longest = std::max(longest, source.samples(i));
  const file::Shares shares(longest, samples);
  for (std::size_t index = 0; index < shares.blocks(); ++index) {
    report(progress, static_cast<double>(index) / static_cast<double>(shares.blocks()), "reading");
    std::vector<std::pair<const void*, std::size_t>> shared;  // stamps of the whole, and the channel that has the part
    for (std::size_t i = 0; i < block.channels.size(); ++i) {
      Channel& channel = block.channels[i];
      const std::size_t first = shares.first(source.samples(i), index);
      const std::size_t count = shares.first(source.samples(i), index + 1) - first;
      const Timeline& whole = source.frame().channels[i].timeline;
      const auto same = std::find_if(shared.begin(), shared.end(),
                                     [&](const auto& entry) { return entry.first == whole.stamps.get(); });
      const bool known = !whole.uniform() && same != shared.end();
      channel.timeline = known ? block.channels[same->second].timeline : source.times(i, first, count);
      if (!known) shared.emplace_back(whole.stamps.get(), i);
      channel.values.clear();
      source.append(i, first, count, channel);
    }
    sink(block);
    block.findings.clear();
  }
}

namespace {

/// A source and the options that it was opened with.
struct OpenSource {
  ReadOptions options;
  Source source;

  OpenSource(const std::string& path, ReadOptions given)
      : options(std::move(given)), source(path, options, Stamps::ignored) {}
};

}  // namespace

SampleReader samples(const std::string& path, const ReadOptions& options) {
  const Session session;
  auto open = std::shared_ptr<OpenSource>(new OpenSource(path, options), [](OpenSource* opened) {
    const Session closing;
    delete opened;
  });
  return [open](std::size_t channel, std::size_t first, std::size_t count, std::vector<double>& to) {
    const Session reading;
    const Channel& of = open->source.frame().channels[channel];
    Channel part{of.name, of.kind, of.unit, {}, {}};
    part.values.swap(to);
    open->source.append(channel, first, count, part);
    part.values.swap(to);
  };
}

}  // namespace tumble::hdf5
