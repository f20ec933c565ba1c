#include "tumble/formats/wav/layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>
#include <vector>

#include "tumble/formats/file/number_at.hpp"
#include "tumble/formats/file/window.hpp"
#include "tumble/units/error.hpp"

namespace tumble::wav {
namespace {

constexpr std::size_t chunk_head = 8;  ///< name, u32 size
constexpr std::uint32_t elsewhere = 0xffffffff;
constexpr std::uint16_t pcm = 1, ieee_float = 3, extensible = 0xfffe;
constexpr std::size_t largest_list = 65536;  ///< [bytes] of a list of texts that is read

[[noreturn]] void fail(const std::string& path, const Sentence& what) {
  throw Error(Error::Kind::bad_file, say("'{}' {}", path, what));
}

/// `width`: [bytes] that a sample takes, of which integers may use fewer `bits`.
Layout::Type type_of(const std::string& path, std::uint16_t format, std::uint16_t bits, std::size_t width) {
  using Type = Layout::Type;
  static constexpr Type integers[] = {Type::u8, Type::i16, Type::i24, Type::i32};
  if (format == pcm && width >= 1 && width <= 4 && bits > 0 && bits <= 8 * width) return integers[width - 1];
  if (format == ieee_float && bits == 32 && width == 4) return Type::f32;
  if (format == ieee_float && bits == 64 && width == 8) return Type::f64;
  fail(path, say("has samples of format {} with {} bits in {} bytes; read are integers of up to 32 bits (format 1) "
                 "and floating-point numbers of 32 and 64 bits (format 3)",
                 format, bits, width));
}

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path), window_(path) {}

  Layout read() {
    if (!window_.holds(12)) fail(path_, "is cut off within its first 12 bytes");
    layout_.big = std::string_view(window_.data(), 4) == "RIFX";
    window_.skip(12);
    bool data = false;
    while (!data && window_.holds(chunk_head)) {
      const std::string name(window_.data(), 4);
      std::uint64_t size = number<std::uint32_t>(window_.data() + 4);
      window_.skip(chunk_head);
      if (name == "data") {
        take_data(size);
        data = true;
        break;
      }
      const std::size_t begin = window_.position();
      if (name == "ds64" && window_.holds(16)) data_size_ = number<std::uint64_t>(window_.data() + 8);
      if (name == "fmt ") take_format(size);
      if (name == "LIST" && size <= largest_list && window_.holds(size)) take_texts(size);
      window_.skip(size + size % 2 - (window_.position() - begin));
    }
    if (!data) fail(path_, "has no samples: there is no chunk 'data' (is it cut off?)");
    return layout_;
  }

 private:
  template <class T>
  T number(const char* at) const {
    return file::number_at<T>(at, layout_.big);
  }

  void take_format(std::uint64_t size) {
    if (size < 16 || !window_.holds(std::min<std::uint64_t>(size, 40)))
      fail(path_, "has a chunk 'fmt ' that is cut off");
    const char* const at = window_.data();
    auto format = number<std::uint16_t>(at);
    if (format == extensible && size >= 40) format = number<std::uint16_t>(at + 24);
    layout_.channels = number<std::uint16_t>(at + 2);
    layout_.rate = number<std::uint32_t>(at + 4);
    const auto frame = number<std::uint16_t>(at + 12), bits = number<std::uint16_t>(at + 14);
    if (layout_.channels == 0) fail(path_, "says that it has no channels");
    if (!(layout_.rate > 0.0)) fail(path_, "says that its sampling rate is 0 Hz");
    layout_.type = type_of(path_, format, bits, frame / layout_.channels);
    if (frame != layout_.channels * size_of(layout_.type))
      fail(path_,
           say("contradicts itself: {} channels of {} bits do not make {} bytes", layout_.channels, bits, frame));
  }

  /// Texts of the list INFO.
  void take_texts(std::uint64_t size) {
    const char* at = window_.data();
    const char* const end = at + size;
    if (size < 4 || std::memcmp(at, "INFO", 4) != 0) return;
    for (at += 4; end - at >= static_cast<std::ptrdiff_t>(chunk_head);) {
      const std::string name(at, 4);
      const std::size_t length = number<std::uint32_t>(at + 4);
      at += chunk_head;
      if (length > static_cast<std::size_t>(end - at)) return;
      std::string text(at, std::find(at, at + length, '\0'));
      std::ranges::replace_if(
          text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
      layout_.meta[name] = text;
      at += std::min<std::size_t>(length + length % 2, static_cast<std::size_t>(end - at));
    }
  }

  /// Its size may be unknown (a recorder that was switched off): then the samples go to the end of the file.
  void take_data(std::uint64_t size) {
    if (layout_.channels == 0) fail(path_, "has samples before the chunk 'fmt ' that describes them");
    if (size == elsewhere && data_size_ > 0) size = data_size_;
    layout_.first = window_.position();
    const std::uint64_t rest = window_.size() - layout_.first;
    const std::size_t frame = layout_.channels * size_of(layout_.type);
    if (size > rest || (size == 0 && rest >= frame)) {
      layout_.findings.push_back(
          {Finding::Severity::warning, "wav_size", {{"said", size}, {"present", static_cast<std::size_t>(rest)}}});
      size = rest;
    }
    if (size % frame != 0)
      layout_.findings.push_back(
          {Finding::Severity::warning, "log_cut_off", {{"size", static_cast<std::size_t>(size % frame)}}});
    layout_.frames = size / frame;
    if (layout_.frames == 0) fail(path_, "has no samples: its chunk 'data' is empty (is it cut off?)");
  }

  const std::string& path_;
  file::Window window_;
  Layout layout_;
  std::uint64_t data_size_ = 0;
};

}  // namespace

std::size_t size_of(Layout::Type type) {
  static constexpr std::size_t sizes[] = {1, 2, 3, 4, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

bool is_integer(Layout::Type type) { return type != Layout::Type::f32 && type != Layout::Type::f64; }

double full_scale(Layout::Type type) { return std::ldexp(1.0, static_cast<int>(8 * size_of(type)) - 1); }

bool is_wave(const std::string& path) {
  char bytes[12];
  if (file::InputFile(path).read(bytes, sizeof bytes) < sizeof bytes) return false;
  const std::string_view head(bytes, 4), kind(bytes + 8, 4);
  return (head == "RIFF" || head == "RIFX" || head == "RF64" || head == "BW64") && kind == "WAVE";
}

Layout layout_of(const std::string& path) {
  if (!is_wave(path)) fail(path, "is no WAV file: it does not begin with RIFF, RIFX or RF64, and WAVE");
  return Reader(path).read();
}

}  // namespace tumble::wav
