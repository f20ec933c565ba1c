#include "tumble/pyramid/store/live_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstring>

namespace tumble::store {

bool read_at(int descriptor, std::uint64_t place, void* to, std::size_t bytes) {
  auto* next = static_cast<char*>(to);
  while (bytes > 0) {
    const ssize_t got = pread(descriptor, next, bytes, static_cast<off_t>(place));
    if (got <= 0) return false;
    next += got;
    place += static_cast<std::uint64_t>(got);
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

std::uint64_t end_of_live_file(int descriptor, std::uint64_t size) {
  char signature[8];
  if (!read_at(descriptor, 0, signature, sizeof signature) || std::memcmp(signature, live_signature, 8) != 0) return 0;
  std::uint64_t place = sizeof signature;
  for (LiveHead head;
       read_at(descriptor, place, &head, sizeof head) && head.plausible() && head.length() <= size - place;)
    place += head.length();
  return place;
}

bool is_written(int descriptor) {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return fcntl(descriptor, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

}  // namespace tumble::store
