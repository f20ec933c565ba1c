#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tumble/units/sentence.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {

/// A number that lies in the bytes of a frame, or in a cell of a line of text.
struct FrameNumber {
  enum class Kind { natural, integer, real };
  /// `binary` in bytes; in a line decimal digits, hexadecimal digits of its bits, or a word of up to 8 letters.
  enum class Form : unsigned char { binary, decimal, hex, word };
  Kind kind = Kind::natural;
  int bytes = 1;     ///< 1 to 8
  int bits = 8;      ///< of the value, from `shift` upwards; a real number has all
  int shift = 0;     ///< [bit] of the least of them
  bool big = false;  ///< the first byte has the highest digits
  Form form = Form::binary;
  int at = 0;     ///< [byte] from the begin of its item or of the frame; negative: from the end of the frame
  int item = -1;  ///< that it lies in, as an index into FrameLayout::items; -1: the frame itself
};

/// Whether a number of the frame, modulo `modulus` where that is not 0, equals a value.
struct FrameCondition {
  FrameNumber number;
  std::uint64_t modulus = 0, equals = 0;
};

/// One signal of the instrument, which one or several frames carry.
struct FrameChannel {
  std::string name;
  Unit unit;               ///< in which people see it; of an increment already divided by the time of a sample
  bool increment = false;  ///< values are what accumulated over one sample: times the rate they are the signal
};

/// How a channel lies in a frame: value [SI] = number * factor + zero.
struct FrameField {
  std::size_t channel = 0;
  FrameNumber number;
  double factor = 1.0, zero = 0.0;
  std::optional<FrameCondition> when = {};  ///< the frame carries the channel only then
};

/// A status that the instrument reports about itself.
struct FrameStatus {
  FrameCondition good;
  std::vector<std::size_t> channels;  ///< that it is about
  bool fails = true;                  ///< where it is not good, the samples of the channels are missing
  std::string text;                   ///< "gyro x is valid"
};

/// A checksum over ranges of bytes. Ends that are not positive count from the end of the frame.
struct FrameChecksum {
  enum class Kind { crc, sum, exclusive_or, fletcher };
  Kind kind = Kind::crc;
  int width = 8;  ///< [bit] 8, 16, 24 or 32
  std::uint32_t poly = 0, init = 0, xorout = 0;
  bool reflected = false;                 ///< bits of the bytes, and of the result, in reverse
  bool negated = false;                   ///< of a sum: the bytes and the checksum sum to zero
  int words = 1;                          ///< [byte] of what is summed
  int pad = 0;                            ///< zero bytes that a CRC takes in at the end
  bool big = false;                       ///< order of its own bytes, and of the words
  std::vector<std::pair<int, int>> over;  ///< from, to [byte]
  int at = 0;                             ///< [byte]
  std::vector<std::uint32_t> table = {};  ///< of a CRC (codec/checksum.hpp)
  std::string after = {};   ///< of a line: the text before the range, empty where it is the begin of the line
  std::string before = {};  ///< of a line: the text behind the range, which the hexadecimal digits follow
  std::string none = {};    ///< of a line: letters in place of digits that mean no checksum
};

/// One piece of a frame that is put together as the instrument is configured.
struct FrameItem {
  std::uint64_t id = 0;  ///< in a list; with masks: 64 times the mask, plus the bit
  int size = 0;          ///< [byte] that its fields need at least
};

/// Items one behind the other, each with an id and a size before its data.
struct FrameItemList {
  int from = 0, to = 0;  ///< [byte] of the frame
  int id_bytes = 1, size_bytes = 1;
  bool size_first = false;
  bool size_counts_head = false;
  bool big = false;
};

/// A number whose bits say which items follow one behind the other, in the order of the bits.
struct FrameMask {
  FrameNumber number;
  std::vector<int> sizes;  ///< [byte] by bit
};

/// How a number is written into a cell of a line. Reading does not depend on it.
struct FrameFormat {
  bool plus = false;  ///< positive numbers have a sign
  bool zeros = true;  ///< in front, to the width; else spaces
  int width = 0;      ///< [character] at least
  int decimals = -1;  ///< behind the point; -1: as many as the value has
  bool given = false;
};

/// Where the characters of a number are in a line. Its item has the same index.
struct FrameCell {
  int column = -1;        ///< from 0, behind the head; -1: of fixed width
  int at = 0, width = 0;  ///< [byte] of the line, where of fixed width
  FrameFormat format = {};
};

/// A frame that is a line of text.
struct FrameText {
  char delimiter = ',';  ///< of columns; a space: spaces and tabs in any number
  int least = 0;         ///< columns
  int most = 0;          ///< columns; 0: the line has none, all cells are of fixed width
  int length = 0;        ///< [byte] without the end of the line, where cells are of fixed width; at least
  std::vector<FrameCell> cells = {};
  std::vector<int> items = {};  ///< by column: the index of its cell, -1 where it is skipped
};

struct FrameCounter {
  FrameNumber number;
  std::uint64_t modulus = 256;
  std::uint64_t step = 1;  ///< from frame to frame; 0: as the stream shows
  int lock = 0;            ///< so many frames in a row must count, to find frames without `sync`; 0: not so
};

/// A part of the time of the device; the time [s] is the sum of its parts.
struct FrameTime {
  FrameNumber number;
  double factor = 1.0;  ///< [s]
  double wrap = 0.0;    ///< [s] after which it begins again, 0: never
  int choice = 0;       ///< parts of one choice belong together; the first choice that a frame has counts
};

/// One kind of frame.
struct FrameLayout {
  std::string name;
  std::string sync, sync_mask;  ///< the first bytes, and which of their bits are fixed; of a line its head
  std::string end;              ///< the last bytes; of a line a CR before its last byte may be absent or present
  int length = 0;               ///< [byte] all of it; the least, where a number or masks say more
  int longest = 512;            ///< [byte] where a number or masks say its length
  std::optional<FrameNumber> length_number = {};
  int length_add = 0;  ///< [byte] to add to that number
  std::optional<FrameItemList> list = {};
  std::vector<FrameMask> masks = {};
  int masks_from = 0;  ///< [byte] where the items of the masks begin
  int masks_tail = 0;  ///< [byte] that follow them
  std::vector<FrameItem> items = {};
  std::optional<FrameText> text = {};
  std::vector<FrameChecksum> checks = {};  ///< all hold; of a line the one with as many digits as the line has
  std::optional<FrameCounter> counter = {};
  std::vector<FrameTime> time = {};
  std::vector<FrameStatus> statuses = {};
  std::vector<FrameField> fields = {};
};

/// Contents of a frame: a value [SI] for each channel of the codec that it carries.
struct FrameContent {
  std::size_t frame = 0;               ///< index of its layout
  std::vector<double> values;          ///< [SI] by channel; NaN: not valid
  std::vector<unsigned char> present;  ///< by channel: whether the frame carries it
  std::optional<std::uint64_t> counter = {};
  std::optional<double> time = {};  ///< [s] of the device
  double wrap = 0.0;                ///< [s] after which that time begins again, 0: never
  std::uint64_t not_good = 0;       ///< statuses of the layout that are not good, a bit each
  int unreadable = 0;               ///< cells of a line that should be numbers and are not; their values are missing
};

/// Bytes and what they mean, to test a declaration with.
struct FrameVector {
  struct Value {
    double si = 0.0, tolerance = 0.0;  ///< [SI] half a unit of the last digit written
  };
  std::string bytes;
  std::map<std::string, Value> values;  ///< by channel
  std::optional<std::uint64_t> counter = {};
  std::optional<Value> time = {};  ///< [s]
  std::string source;
  bool made_by_hand = false;  ///< from the table, where no capture is at hand
  std::string variant;        ///< of the declaration for which it holds; empty: the one without variants
  std::string place;          ///< file:line
};

/// The serial line, and what starts and stops the stream.
struct FrameLink {
  long baud = 0;
  std::string format;                                      ///< "8N1"
  std::vector<std::pair<std::string, std::string>> start;  ///< to send, and the answer that is expected
  std::vector<std::pair<std::string, std::string>> stop;
};

/// How certain a declaration is.
enum class FrameCertainty { maker, crossed, driver, computed, uncertain };
std::string_view name(FrameCertainty certainty);

/// The frames of an instrument, ready to decode and to encode.
struct FrameCodec {
  std::string name;
  std::string title, source, note;
  FrameCertainty certainty = FrameCertainty::uncertain;
  FrameLink link;
  double rate = 0.0;    ///< [Hz] of the frames, where declared; 0: not
  std::string between;  ///< bytes that may stand between frames
  std::vector<FrameChannel> channels;
  std::vector<FrameLayout> frames;
  std::vector<FrameVector> vectors;
  std::vector<std::string> variants;  ///< that the declaration offers
  std::vector<std::string> unchosen;  ///< scales that only a variant says; values that use them are without meaning
};

/// Reads a declaration of frames (docs/formats/frames.md has its keys).
///
/// Given     text      of the declaration, TOML
///           file      its name, for messages
///           variants  of it that are wanted, by name
///
/// Returned  the codec, of which every test vector holds
///
/// Throws    Error::bad_input with all problems, each with its line
FrameCodec read_frames(std::string_view text, const std::string& file, const std::vector<std::string>& variants = {});

/// Problems of the test vectors of a codec, decoded and encoded again; empty: all hold.
Problems problems_of_vectors(const FrameCodec& codec);

/// Something that happened in a stream: how often, and the first byte of the first.
struct FrameIncident {
  std::uint64_t count = 0;
  std::uint64_t first = 0;  ///< [byte] of the stream
};

/// How a stream was.
struct FrameCounts {
  std::uint64_t bytes = 0;           ///< in all
  std::uint64_t good_bytes = 0;      ///< in frames whose checksums hold
  std::uint64_t good = 0;            ///< frames
  std::uint64_t channel_frames = 0;  ///< good frames that carry a channel, also while they wait for others
  std::vector<std::uint64_t> by_layout;
  std::vector<std::vector<FrameIncident>> not_good;  ///< by layout and status
  FrameIncident damaged;            ///< frames whose checksum does not hold, or whose columns are others
  FrameIncident skipped;            ///< places with bytes that belong to no frame
  std::uint64_t skipped_bytes = 0;  ///< bytes in these
  FrameIncident gaps;               ///< places where frames are missing
  std::uint64_t lost = 0;           ///< frames that are missing in these
  FrameIncident repeated;           ///< frames that came twice; the second was removed
  FrameIncident exchanged;          ///< frames that came behind later ones, and were put in order
  FrameIncident too_late;           ///< frames that came so much later that they were removed
  FrameIncident restarts;           ///< places where the counter began again, so that it shows no loss
  std::uint64_t cut = 0;            ///< bytes of a frame that the end of the stream cuts
  FrameIncident unreadable;         ///< cells of lines that are not numbers
};

/// A frame of a stream.
struct StreamFrame {
  FrameContent content;
  std::uint64_t offset = 0;    ///< [byte] of the stream
  std::uint64_t complete = 0;  ///< [byte] of the stream behind it, or behind a later frame that came before it
  std::uint64_t sequence = 0;  ///< its number among the frames that carry channels, lost ones counted
  std::uint64_t restarts = 0;  ///< of the counter before it: how many frames are lost there is not known, none counted
  std::optional<double> time;  ///< [s] of the device, without its wraps; a frame without time has that of the last one
};

using FrameSink = std::function<void(const StreamFrame&)>;

/// Decodes a stream piece by piece: finds the frames, checks them, puts them in the order of their counter
/// (codec/order.hpp), and finds the next one after garbage. Frames that carry no channel are counted, and not handed
/// out.
class FrameStream {
 public:
  explicit FrameStream(const FrameCodec& codec);  ///< the codec must live as long
  FrameStream(FrameStream&& other) noexcept;
  FrameStream& operator=(FrameStream&& other) noexcept;
  ~FrameStream();
  void feed(std::string_view bytes, const FrameSink& sink);
  /// Ends the stream: bytes that wait for more are decoded or counted as cut off, then frames that wait for earlier
  /// ones are handed out.
  void finish(const FrameSink& sink);
  bool holds() const;                 ///< frames that wait for others
  void flush(const FrameSink& sink);  ///< hands them out
  /// Notes that the instrument was commanded to start or to stop: until the next frame it answers, which is no garbage,
  /// and its counter may begin anew, which is no loss.
  void begin_again();
  const FrameCounts& counts() const { return counts_; }

  enum class State { none, waits, damaged, good };  ///< of bytes that may be a frame

 private:
  struct Clock {
    double wraps = 0.0, last = 0.0;  ///< [s]
    bool running = false;
  };
  struct Candidate {
    State state = State::none;
    std::size_t frame = 0, length = 0;
  };

  void work(bool last, const FrameSink& sink);
  Candidate candidate_at(std::size_t at, bool last) const;
  Candidate counted_at(std::size_t frame, std::size_t at, bool last) const;
  bool is_unproven(std::size_t at, const Candidate& found);
  bool may_begin_line(const FrameLayout& layout, std::size_t at) const;
  void skip(std::size_t at);
  void accept(std::size_t at, const Candidate& found, const FrameSink& sink);
  void take_note(const StreamFrame& frame);
  void hand_out(StreamFrame& frame, std::uint64_t lost, bool anew, const FrameSink& sink);
  void unwrap_time(StreamFrame& frame);

  const FrameCodec* codec_;
  std::vector<unsigned char> first_;  ///< by byte: bit 0 a frame may begin with it, bit 1 it may stand between
  std::vector<bool> carries_;         ///< by layout: a channel
  std::string pending_;
  char before_ = '\0';               ///< the byte before `pending_`
  std::uint64_t base_ = 0;           ///< [byte] of the stream where `pending_` begins
  std::uint64_t expected_ = 0;       ///< where the next frame should begin
  std::uint64_t accounted_ = 0;      ///< bytes before it belong to frames or are counted
  std::uint64_t proven_ = 0;         ///< where frames that are found by their counter are used from
  std::uint64_t bad_bytes_ = 0;      ///< in no good frame since the last one that carries channels
  bool in_run_ = false;              ///< of skipped bytes
  bool answers_ = false;             ///< bytes that are skipped are answers of the instrument
  bool counted_ = false;             ///< some layout has a counter
  std::optional<std::size_t> main_;  ///< without counters: the layout whose frames the sequence counts
  struct Order;
  std::unique_ptr<Order> order_;
  std::uint64_t sequence_ = 0, restarts_ = 0;  ///< of the last frame that was handed out
  bool begun_ = false;                         ///< one was
  Clock clock_;
  StreamFrame frame_;
  FrameCounts counts_;
};

/// Decodes one frame, checksums too. Nothing where the bytes are not a whole frame of one of the layouts.
std::optional<FrameContent> decode_frame(const FrameCodec& codec, std::string_view bytes);

/// The bytes of a frame with this content: fields, counter, time and checksums written, status good, everything else
/// as in `base`, or 0 where that is empty. Items are those whose channels are present.
/// Throws Error::bad_input where a value does not fit into its bytes.
std::string encode_frame(const FrameCodec& codec, const FrameContent& content, std::string_view base = {});

/// Encodes frames one after the other: what frames with the same channels have in common is put together once.
class FrameEncoder {
 public:
  /// Puts encode_frame(codec, content) behind `out`. The codec is the same each time, or a copy of it.
  /// Throws as encode_frame(); `out` is then as before.
  void append(const FrameCodec& codec, const FrameContent& content, std::string& out);

 private:
  static bool keeps(const FrameLayout& layout);

  std::size_t frame_ = 0;
  std::vector<unsigned char> present_;
  bool counted_ = false, timed_ = false;
  std::string skeleton_, draft_;     ///< without the content; room for one frame
  std::vector<std::size_t> fields_;  ///< of the layout, that carry the channels
};

}  // namespace tumble
