#include "tumble/formats/file/window.hpp"

#include <algorithm>
#include <cstring>

namespace tumble::file {

Window::Window(const std::string& path)
    : file_(path), buffer_(std::min(2 * longest, file_.size() + 1)), at_(buffer_.data()), end_(buffer_.data()) {}

bool Window::refill(std::size_t count) {
  const std::size_t rest = available();
  std::memmove(buffer_.data(), at_, rest);
  at_ = buffer_.data();
  char* end = buffer_.data() + rest;
  while (static_cast<std::size_t>(end - at_) < count) {
    const std::size_t got = file_.read(end, static_cast<std::size_t>(buffer_.data() + buffer_.size() - end));
    end += got;
    read_ += got;
    if (got == 0) break;
  }
  end_ = end;
  return available() >= count;
}

void Window::skip_on(std::size_t count) {
  while (count > 0) {
    const std::size_t now = std::min(count, available());
    at_ += now;
    count -= now;
    if (count > 0 && !holds(1)) return;
  }
}

}  // namespace tumble::file
