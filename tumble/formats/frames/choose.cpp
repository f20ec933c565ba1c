#include "tumble/formats/frames/choose.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/text_parts.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble::frames {

namespace {

/// The codecs of all shipped declarations, made once.
const std::vector<FrameCodec>& shipped_codecs() {
  static const std::vector<FrameCodec> codecs = [] {
    std::vector<FrameCodec> all;
    for (const auto& instrument : shipped_instruments()) all.push_back(codec_of(instrument));
    return all;
  }();
  return codecs;
}

FrameCounts counts_in(const FrameCodec& codec, std::string_view bytes) {
  FrameStream stream(codec);
  stream.feed(bytes, [](const StreamFrame&) {});
  stream.finish([](const StreamFrame&) {});
  return stream.counts();
}

/// Whether no checksum shows its frames, but a counter of a few bits or their head alone: many other streams have that.
bool is_unchecked(const FrameCodec& codec) {
  return std::ranges::any_of(codec.frames, [](const FrameLayout& frame) {
    return !frame.fields.empty() && !frame.text && frame.checks.empty();
  });
}

Match match_of(const FrameCodec& codec, std::string_view bytes) {
  const FrameCounts counts = counts_in(codec, bytes);
  Match match{codec.name, counts.channel_frames};
  const auto whole = counts.bytes - counts.cut;
  match.part = whole == 0 ? 0.0 : static_cast<double>(counts.good_bytes) / static_cast<double>(whole);
  match.explains =
      !is_unchecked(codec) && match.part >= 0.5 && (match.frames >= 3 || (match.frames >= 1 && match.part == 1.0));
  return match;
}

FrameCodec named_codec(const std::string& text) {
  const InstrumentChoice choice = parse_instrument(text);
  try {
    if (!choice.name.ends_with(".toml")) return codec_of(find_instrument(choice.name), choice.variants);
    FrameCodec codec = read_frames(read_text_file(choice.name), choice.name, choice.variants);
    return codec;
  } catch (const Error& error) {
    throw Error(error.kind == Error::Kind::bad_file ? Error::Kind::bad_file : Error::Kind::bad_input, error.problems);
  }
}

/// `kind`: whose fault it is.
void require_variants(const FrameCodec& codec, Error::Kind kind) {
  if (codec.unchosen.empty()) return;
  throw Error(kind, say("the frames of {} do not say what their numbers mean ({}); name the variant of the device, for "
                        "example --set frames={}:{} (variants: {})",
                        Name{codec.name}, fmt::join(codec.unchosen, ", "), Name{codec.name},
                        Name{codec.variants.front()}, fmt::join(codec.variants, ", ")));
}

/// The layouts that --topic names keep their channels.
void keep_topics(FrameCodec& codec, const std::vector<std::string>& topics) {
  if (topics.empty()) return;
  std::vector<std::string> known;
  for (const FrameLayout& layout : codec.frames)
    if (!layout.fields.empty()) known.push_back(layout.name);
  Problems problems;
  for (const auto& topic : topics)
    if (std::ranges::find(known, topic) == known.end())
      problems.push_back(say("{} has no frame '{}'{} (frames: {})", Name{codec.name}, topic, did_you_mean(topic, known),
                             fmt::join(known, ", ")));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  for (FrameLayout& layout : codec.frames)
    if (std::ranges::find(topics, layout.name) == topics.end()) layout.fields.clear();
}

std::string listed(const std::vector<Match>& matches) {
  std::vector<std::string> each;
  for (const Match& match : matches) each.push_back(fmt::format("{} ({:.0f} %)", match.name, 100.0 * match.part));
  return joined(each);
}

}  // namespace

std::vector<Match> matches_of(std::string_view bytes) {
  std::vector<Match> matches;
  for (const FrameCodec& codec : shipped_codecs())
    if (Match match = match_of(codec, bytes); match.frames > 0) matches.push_back(std::move(match));
  std::ranges::stable_sort(matches, std::ranges::greater{}, &Match::part);
  return matches;
}

std::string beginning_of(const std::string& path) {
  file::InputFile file(path);
  std::string bytes(std::min(file.size(), first_bytes), '\0');
  std::size_t size = 0;
  while (const std::size_t count = file.read(bytes.data() + size, bytes.size() - size)) size += count;
  bytes.resize(size);
  return bytes;
}

Chosen choose(const std::string& path, const ReadOptions& options) {
  Chosen chosen;
  if (!options.frames.empty()) {
    chosen.codec = named_codec(options.frames);
  } else {
    const auto matches = matches_of(beginning_of(path));
    const auto good = std::ranges::count_if(matches, &Match::explains);
    if (good != 1)
      throw Error(Error::Kind::bad_file,
                  say("'{}': {}; name the declaration of its frames, --set frames=NAME (shipped: tumble list "
                      "instruments), or write one (docs/formats/frames.md)",
                      path,
                      matches.empty() ? Sentence("no shipped declaration finds a frame in its first bytes")
                      : good == 0     ? say("no shipped declaration explains half of its first bytes; nearest are {}",
                                            Name{listed(matches)})
                                  : say("several declarations explain its first bytes: {}", Name{listed(matches)})));
    const auto& match = *std::ranges::find_if(matches, &Match::explains);
    chosen = {codec_of(find_instrument(match.name)), true, match.part};
  }
  require_variants(chosen.codec, chosen.recognised ? Error::Kind::bad_file : Error::Kind::bad_input);
  keep_topics(chosen.codec, options.topics);
  return chosen;
}

}  // namespace tumble::frames
