#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "tumble/serve/http_server.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

const std::string* find_query(const HttpRequest& request, std::string_view name) {
  for (const auto& [key, value] : request.query)
    if (key == name) return &value;
  return nullptr;
}

BodyFile::BodyFile(const std::string& path)
    : path_(path), descriptor_(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666)) {
  if (descriptor_ < 0) throw Error{Error::Kind::bad_file, say("cannot write '{}': {}", path, system_reason(errno))};
}

BodyFile::~BodyFile() {
  close(descriptor_);
  unlink(path_.c_str());
}

bool BodyFile::write(const char* bytes, std::size_t count) {
  while (count > 0) {
    const auto now = ::write(descriptor_, bytes, count);
    if (now < 0 && errno == EINTR) continue;
    if (now <= 0) return false;
    bytes += now;
    count -= static_cast<std::size_t>(now);
  }
  return true;
}

}  // namespace tumble
