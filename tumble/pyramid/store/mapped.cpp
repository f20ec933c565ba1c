#include "tumble/pyramid/store/mapped.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>

#include "tumble/units/error.hpp"

namespace tumble::store {

Mapped::Mapped(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (descriptor >= 0 && fstat(descriptor, &status) == 0 && status.st_size > 0) {
    size_ = static_cast<std::size_t>(status.st_size);
    void* const place = mmap(nullptr, size_, PROT_READ, MAP_SHARED, descriptor, 0);
    if (place != MAP_FAILED) bytes_ = static_cast<const char*>(place);
  }
  if (descriptor >= 0) close(descriptor);
  if (!bytes_) throw Error{Error::Kind::bad_file, say("'{}' cannot be read", path)};
}

Mapped::~Mapped() { munmap(const_cast<char*>(bytes_), size_); }

void Mapped::damaged() { throw Error{Error::Kind::bad_file, "the pyramid of the recording is damaged"}; }

MappedChannel mapped(const Mapped& file, const Json& entry) {
  MappedChannel channel;
  channel.count = entry.at("count").get<std::size_t>();
  channel.clock = entry.at("clock").get<std::size_t>();
  channel.offset = entry.at("offset").get<double>();
  channel.start = entry.at("start").get<double>();
  channel.rate = entry.at("rate").get<double>();
  channel.samples = Pieces(file, entry.at("samples"), channel.count);
  channel.stamps = Pieces(file, entry.at("stamps"), channel.count);
  for (const Json& level : entry.at("levels")) {
    const auto count = level.at("count").get<std::size_t>();
    channel.levels.push_back({count, Paged(file.numbers<float>(level.at("low"), count)),
                              Paged(file.numbers<float>(level.at("high"), count)),
                              Paged(file.numbers<std::uint8_t>(level.at("flags"), count))});
  }
  for (const Json& level : entry.at("moments")) {
    const auto count = level.at("count").get<std::size_t>();
    channel.moments.push_back({count, Paged(file.numbers<Moments>(level.at("place"), count))});
  }
  return channel;
}

Json description_in(const Mapped& file) {
  constexpr std::size_t tail = 24;
  if (file.size() < 8 + tail || std::memcmp(file.at(0), signature, 8) != 0 ||
      std::memcmp(file.at(file.size() - 8), signature, 8) != 0)
    Mapped::damaged();
  std::uint64_t size = 0, place = 0;
  std::memcpy(&size, file.at(file.size() - 24), 8);
  std::memcpy(&place, file.at(file.size() - 16), 8);
  if (place > file.size() || size > file.size() - place) Mapped::damaged();
  const std::string_view text(file.at(place), size);
  Json description = Json::parse(text, nullptr, false);
  if (description.is_discarded()) Mapped::damaged();
  return description;
}

}  // namespace tumble::store
