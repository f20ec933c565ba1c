#include "tumble/recorder/live_store/chunk.hpp"

#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "tumble/recorder/live_store/text.hpp"

namespace tumble::live_store {

static_assert(std::endian::native == std::endian::little, "numbers of a store are little endian");

namespace {

template <class Number>
void put(std::string& body, Number number) {
  char bytes[sizeof number];
  std::memcpy(bytes, &number, sizeof number);
  body.append(bytes, sizeof number);
}

void put_head(Chunk& chunk, std::uint64_t sequence, double time) {
  if (chunk.count++ == 0) {
    chunk.first = sequence;
    chunk.begin = chunk.end = time;
  }
  chunk.last = sequence;
  chunk.begin = std::fmin(chunk.begin, time);
  chunk.end = std::fmax(chunk.end, time);
}

/// Every item begins with its sequence number, counted from the first of the chunk, and its time.
void put_begin(Chunk& chunk, std::uint64_t sequence, double time) {
  put_head(chunk, sequence, time);
  put(chunk.body, static_cast<std::uint32_t>(sequence - chunk.first));
  put(chunk.body, time);
}

/// The bytes of a body one after the other.
class Reader {
 public:
  explicit Reader(std::string_view body) : body_(body) {}
  bool more() const { return !body_.empty() && good_; }
  bool good() const { return good_; }
  template <class Number>
  Number number() {
    Number value{};
    const std::string_view bytes = take(sizeof value);
    if (good_) std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  std::string_view take(std::size_t size) {
    if (size > body_.size()) {
      good_ = false;
      return {};
    }
    const std::string_view bytes = body_.substr(0, size);
    body_.remove_prefix(size);
    return bytes;
  }

 private:
  std::string_view body_;
  bool good_ = true;
};

void read_raw(Reader& reader, StoreItem& item) {
  item.direction = static_cast<StoreDirection>(reader.number<std::uint8_t>());
  item.bytes = reader.take(reader.number<std::uint32_t>());
}

void read_sample(Reader& reader, std::vector<double>& values, StoreItem& item) {
  const double device = reader.number<double>();
  item.sample.device = std::isnan(device) ? std::nullopt : std::optional(device);
  item.sample.sequence = reader.number<std::uint64_t>();
  const std::string_view bytes = reader.take(values.size() * sizeof(double));
  if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  item.sample.time = item.time;
  item.sample.values = values;
}

}  // namespace

void put_raw(Chunk& chunk, std::uint64_t sequence, StoreDirection direction, double time, std::string_view bytes) {
  put_begin(chunk, sequence, time);
  put(chunk.body, static_cast<std::uint8_t>(direction));
  put(chunk.body, static_cast<std::uint32_t>(bytes.size()));
  chunk.body += bytes;
}

void put_sample(Chunk& chunk, std::uint64_t sequence, const StoreSample& sample) {
  put_begin(chunk, sequence, sample.time);
  put(chunk.body, sample.device.value_or(std::nan("")));
  put(chunk.body, sample.sequence);
  chunk.body.append(reinterpret_cast<const char*>(sample.values.data()), sample.values.size_bytes());
}

void put_text(Chunk& chunk, std::uint64_t sequence, double time, std::string text) {
  put_head(chunk, sequence, time);
  chunk.body = std::move(text);
}

bool items_of(const Chunk& chunk, std::size_t channels, const std::function<void(const StoreItem&)>& visit) {
  if (chunk.kind == StoreItem::Kind::event || chunk.kind == StoreItem::Kind::journal)
    return items_of_text(chunk, visit);
  Reader reader(chunk.body);
  std::vector<double> values(channels);
  while (reader.more()) {
    StoreItem item{.kind = chunk.kind, .source = chunk.source};
    item.sequence = chunk.first + reader.number<std::uint32_t>();
    item.time = reader.number<double>();
    if (chunk.kind == StoreItem::Kind::raw)
      read_raw(reader, item);
    else
      read_sample(reader, values, item);
    if (!reader.good()) return false;
    visit(item);
  }
  return reader.good();
}

std::uint32_t checksum_of(std::string_view body) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const unsigned char*>(body.data()), body.size()));
}

}  // namespace tumble::live_store
